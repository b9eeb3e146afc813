"""rosbag: what is written is read again, by the stand-in and by rosbags."""

import pytest
from rosbags.rosbag1 import Reader, Writer
from rosbags.typesys import Stores, get_typestore

from tracerisk.common.sandbox.files.moved_files import MovedFiles


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / "motion.bag")


def written(path, mode="w", **options):
    import rosbag
    import rospy
    from sensor_msgs.msg import JointState
    from std_msgs.msg import String

    with rosbag.Bag(path, mode, **options) as bag:
        for second in range(1, 5):
            state = JointState(name=["a"], position=[float(second)])
            bag.write("/joint_states", state, rospy.Time(second))
        bag.write("note", String("done"), rospy.Time(4, 500))


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_messages_are_read_as_they_were_written(run_node, path, compression):
    def main():
        import rosbag
        import rospy

        written(path, compression=compression)
        with rosbag.Bag(path) as bag:
            states = [(each.message.position[0], each.timestamp) for each in list(bag)[:4]]
            some = bag.read_messages("joint_states", rospy.Time(2), rospy.Time(3))
            between = [message.position[0] for _, message, _ in some]
            info = bag.get_type_and_topic_info()
            ends = bag.get_start_time(), bag.get_end_time(), bag.get_message_count(["note"])
            nothing = list(bag.read_messages("other"))
        return states, between, info, ends, nothing, rospy.Time

    states, between, info, ends, nothing, kind = run_node(main)
    assert states == [(float(second), kind(second)) for second in range(1, 5)]
    assert between == [2.0, 3.0]
    assert info.topics["/joint_states"] == ("sensor_msgs/JointState", 4, 1, 1.0)
    assert info.topics["note"].frequency is None
    assert info.msg_types["std_msgs/String"] == "992ce8a1687cec8c8bd883ec73ca41d1"
    assert ends == (1.0, pytest.approx(4.0000005), 1)
    assert nothing == []


def test_rosbags_reads_what_is_written(run_node, path):
    run_node(lambda: written(path))
    store = get_typestore(Stores.ROS1_NOETIC)
    with Reader(path) as reader:
        (first, at, data), *rest = reader.messages()
    assert (first.topic, at, len(rest)) == ("/joint_states", 1_000_000_000, 4)
    assert store.deserialize_ros1(data, first.msgtype).position.tolist() == [1.0]


def test_a_bag_is_written_on_or_anew(run_node, path):
    def main():
        import rosbag

        written(path)
        written(path, "a")
        with rosbag.Bag(path) as bag:
            more = len(bag)
        written(path)
        with rosbag.Bag(path) as bag:
            return more, len(bag)

    assert run_node(main) == (10, 5)


def test_a_bag_of_the_same_name_elsewhere_is_neither_in_the_way_nor_touched(
    run_node, tmp_path, monkeypatch
):
    here, beside = tmp_path / "here", tmp_path / "beside"
    for folder in (here, beside):
        folder.mkdir()
    (beside / "motion.bag").write_bytes(b"another")
    monkeypatch.chdir(here)
    with MovedFiles({}, tmp_path, lambda *_: None, [beside]).active():
        run_node(lambda: written("motion.bag"))
    assert (beside / "motion.bag").read_bytes() == b"another"
    assert (here / "motion.bag").read_bytes().startswith(b"#ROSBAG")


def test_a_message_without_a_time_is_of_now(run_node, path):
    def main():
        import rosbag
        import rospy
        from std_msgs.msg import String

        rospy.init_node("n")
        rospy.sleep(2.0)
        now = rospy.get_time()
        with rosbag.Bag(path, "w") as bag:
            bag.write("note", String("x"))
        with rosbag.Bag(path) as bag:
            return bag.get_start_time() - now

    assert run_node(main) == pytest.approx(0.0, abs=0.01)


def test_what_cannot_be_read_or_written_is_reported(run_node, path, tmp_path):
    foreign = tmp_path / "foreign.bag"
    with Writer(foreign) as writer:
        text = writer.add_connection(
            "t", "lab_msgs/msg/Secret", msgdef="int32 a\n", md5sum="0" * 32
        )
        writer.write(text, 1, b"\0\0\0\0")

    def main():
        import rosbag
        from std_msgs.msg import String

        reported = []
        (tmp_path / "text.bag").write_text("no bag\n")
        written(path)
        for wrong in (
            lambda: rosbag.Bag(str(tmp_path / "text.bag")),
            lambda: rosbag.Bag(path).write("t", String("x")),
            lambda: next(rosbag.Bag(path, "w").read_messages()),
            lambda: next(rosbag.Bag(str(foreign)).read_messages()),
            lambda: rosbag.Bag(str(tmp_path / "none.bag")),
            lambda: rosbag.Bag(path, "x"),
        ):
            try:
                wrong()
            except (rosbag.ROSBagException, OSError, ValueError) as error:
                reported.append(f"{type(error).__name__}: {error}")
        raw = next(rosbag.Bag(str(foreign)).read_messages(raw=True)).message
        return reported, raw[:3]

    reported, raw = run_node(main)
    assert [each.partition(":")[0] for each in reported] == [
        *("ROSBagFormatException", "ROSBagException", "ROSBagException", "ROSBagException"),
        *("FileNotFoundError", "ValueError"),
    ]
    assert "not open for writing" in reported[1]
    assert "not open for reading" in reported[2]
    assert (
        "messages of lab_msgs/Secret, which is neither in the workspace nor served" in reported[3]
    )
    assert raw == ("lab_msgs/Secret", b"\0\0\0\0", "0" * 32)


def test_a_bag_is_a_stream_as_well(run_node):
    import io

    kept = []

    class Stream(io.BytesIO):
        def close(self):
            kept.append(self.getvalue())
            super().close()

    def main():
        import rosbag

        written(Stream())
        with rosbag.Bag(io.BytesIO(kept[0])) as bag:
            return [each.topic for each in bag]

    assert run_node(main) == ["/joint_states"] * 4 + ["note"]


def test_what_was_recorded_is_chosen_by_its_publisher(run_node, path):
    def main():
        import rosbag
        from std_msgs.msg import String

        written(path)

        def is_wanted(topic, datatype, md5sum, msg_def, header):
            known = (datatype, md5sum, msg_def) == (String._type, String._md5sum, String._full_text)
            return known and header["topic"] == topic

        with rosbag.Bag(path) as bag:
            return [each.topic for each in bag.read_messages(connection_filter=is_wanted)]

    assert run_node(main) == ["note"]


def test_a_bag_knows_its_types_and_sizes(run_node, path):
    def main():
        import rosbag

        written(path, compression="bz2")
        with rosbag.Bag(path) as bag:
            types, topics = bag.get_type_and_topic_info("note")
            assert (sorted(types), list(topics)) == (
                ["sensor_msgs/JointState", "std_msgs/String"],
                ["note"],
            )
            info = bag.get_compression_info()
            assert (info.compression, 0 < info.compressed < info.uncompressed) == ("bz2", True)
        with pytest.raises(ValueError, match="closed bag"):
            bag.size  # noqa: B018 - asking is the test
        with (
            rosbag.Bag(path, "w") as empty,
            pytest.raises(rosbag.ROSBagException, match="no message"),
        ):
            empty.get_start_time()
        with pytest.raises(ValueError, match="none, bz2, lz4"):
            rosbag.Bag(path, compression="zip")
        with pytest.raises(ValueError, match="chunk_threshold"):
            rosbag.Bag(path, chunk_threshold=-1)

    run_node(main)
