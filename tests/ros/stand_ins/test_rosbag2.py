"""rosbag2_py: what is written is read again, by the stand-in and by rosbags."""

import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

SECOND = 1_000_000_000


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / "motion")


def written(path, storage="mcap"):
    import rosbag2_py
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import JointState
    from std_msgs.msg import String

    writer = rosbag2_py.SequentialWriter()
    writer.open(
        rosbag2_py.StorageOptions(uri=path, storage_id=storage),
        rosbag2_py.ConverterOptions("cdr", "cdr"),
    )
    for number, (name, kind) in enumerate(
        (("/joint_states", "sensor_msgs/msg/JointState"), ("/note", "std_msgs/msg/String"))
    ):
        writer.create_topic(
            rosbag2_py.TopicMetadata(id=number, name=name, type=kind, serialization_format="cdr")
        )
    for second in (1, 2, 3):
        state = JointState(name=["a"], position=[float(second)])
        writer.write("/joint_states", serialize_message(state), second * SECOND)
    writer.write("/note", serialize_message(String(data="done")), 2 * SECOND + 1)
    return writer


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_messages_are_read_as_they_were_written(run_ros2, path, storage):
    def main():
        import rosbag2_py
        from rclpy.serialization import deserialize_message
        from sensor_msgs.msg import JointState

        written(path, storage).close()
        reader = rosbag2_py.SequentialReader()
        reader.open(rosbag2_py.StorageOptions(path, storage), rosbag2_py.ConverterOptions())
        topics = {each.name: each.type for each in reader.get_all_topics_and_types()}
        order = []
        while reader.has_next():
            topic, _, at = reader.read_next()
            order.append((topic, at))
        reader.set_filter(rosbag2_py.StorageFilter(topics=["/joint_states"]))
        reader.seek(2 * SECOND)
        data = reader.read_next()[1]
        reader.read_next()
        with pytest.raises(RuntimeError, match="No next message"):
            reader.read_next()
        reader.set_read_order(rosbag2_py.ReadOrder(reverse=True))
        return (
            topics,
            order,
            deserialize_message(data, JointState).position[0],
            reader.read_next()[2],
            rosbag2_py.Info().read_metadata(path, storage),
        )

    topics, order, position, last, info = run_ros2(main)
    assert topics == {"/joint_states": "sensor_msgs/msg/JointState", "/note": "std_msgs/msg/String"}
    assert order == [
        ("/joint_states", SECOND),
        ("/joint_states", 2 * SECOND),
        ("/note", 2 * SECOND + 1),
        ("/joint_states", 3 * SECOND),
    ]
    assert (position, last) == (2.0, 3 * SECOND)
    assert (info.message_count, info.storage_identifier) == (4, storage)
    counts = {
        each.topic_metadata.name: each.message_count for each in info.topics_with_message_count
    }
    assert counts == {"/joint_states": 3, "/note": 1}
    assert info.files[0].path == info.relative_file_paths[0]


def test_rosbags_reads_what_is_written_with_its_definition(run_ros2, path):
    run_ros2(lambda: written(path).close())
    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(path) as reader:
        (first, at, data), *rest = reader.messages()
        (note,) = [each for each in reader.connections if each.topic == "/note"]
    assert (first.topic, at, len(rest)) == ("/joint_states", SECOND, 3)
    assert store.deserialize_cdr(data, first.msgtype).position.tolist() == [1.0]
    assert first.digest == store.hash_rihs01("sensor_msgs/msg/JointState")
    assert "float64[] position" in first.msgdef.data
    assert note.msgdef.data.strip() == "string data"


def test_what_cannot_be_done_says_why(run_ros2, path):
    def main():
        import rosbag2_py

        with pytest.raises(RuntimeError, match="No storage could be initialized"):
            rosbag2_py.SequentialReader().open_uri(path)
        with pytest.raises(RuntimeError, match="not open"):
            rosbag2_py.SequentialWriter().write("/note", b"", 0)
        writer = written(path)
        with pytest.raises(RuntimeError, match="not been created"):
            writer.write("/other", b"", 0)
        with pytest.raises(RuntimeError, match="'no_msgs/msg/Thing' not found"):
            writer.create_topic(rosbag2_py.TopicMetadata("/x", "no_msgs/msg/Thing", "cdr"))
        with pytest.raises(RuntimeError, match="already exists"):
            written(path)
        with pytest.raises(RuntimeError, match="storage plugin 'zip'"):
            written(f"{path}2", "zip")
        with pytest.raises(TypeError, match="TopicMetadata takes"):
            rosbag2_py.TopicMetadata("/x")
        with pytest.raises(RuntimeError, match="format 'json'"):
            rosbag2_py.SequentialReader().open(
                rosbag2_py.StorageOptions(path), rosbag2_py.ConverterOptions("json", "json")
            )

    run_ros2(main)
