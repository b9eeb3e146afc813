"""rosidl_runtime_py: messages as dictionaries and texts, fields from dictionaries, types by name.

Source: ros2/rosidl_runtime_py (branch rolling) `rosidl_runtime_py/*.py` and its `test/`.
"""

import pytest


@pytest.fixture
def point(run_ros2):
    """Run a function with a JointTrajectoryPoint of two positions, and its trajectory."""

    def run(use):
        def main():
            from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

            point = JointTrajectoryPoint(positions=[1.0, 2.5])
            point.time_from_start.sec = 3
            return use(JointTrajectory(joint_names=["shoulder", "elbow"], points=[point]))

        return run_ros2(main)

    return run


def test_a_message_becomes_a_dictionary_in_the_order_of_its_fields(point):
    def use(message):
        from rosidl_runtime_py import message_to_ordereddict

        found = message_to_ordereddict(message)
        short = message_to_ordereddict(message, truncate_length=1)
        bare = message_to_ordereddict(message, no_arr=True, no_str=True)
        return (
            list(found),
            found["points"][0],
            short["joint_names"],
            bare["joint_names"],
            bare["points"],
        )

    names, first, short, texts, points = point(use)
    assert names == ["header", "joint_names", "points"]
    assert first["positions"] == [1.0, 2.5]
    assert first["time_from_start"] == {"sec": 3, "nanosec": 0}
    assert short == ["s...", "..."]
    assert texts == "<sequence type: string, length: 2>"
    assert points == "<sequence type: trajectory_msgs/msg/JointTrajectoryPoint, length: 1>"


def test_a_message_becomes_yaml_and_csv(point):
    def use(message):
        from geometry_msgs.msg import Point, Pose
        from rosidl_runtime_py import message_to_csv, message_to_yaml

        made = Point(x=1.0, y=2.0)
        assert message_to_yaml(Pose()).startswith("position:\n  x: 0.0\n")
        return (
            message_to_yaml(made),
            message_to_yaml(made, flow_style=True),
            message_to_csv(message.points[0]),
            message_to_csv(message, no_arr=True),
        )

    block, flow, values, bare = point(use)
    assert block == "x: 1.0\ny: 2.0\nz: 0.0\n"
    assert flow == "{x: 1.0, y: 2.0, z: 0.0}\n"
    assert values == "1.0,2.5,,,,3,0"
    assert bare.startswith("0,0,,<sequence type: string, length: 2>,")


def test_fields_are_set_from_a_dictionary(point):
    def use(message):
        from rosidl_runtime_py import set_message_fields

        set_message_fields(
            message,
            {
                "header": {"frame_id": "base"},
                "joint_names": ["a"],
                "points": [{"positions": [0.5], "time_from_start": {"sec": 7}}, {}],
            },
        )
        with pytest.raises(AttributeError, match="nope"):
            set_message_fields(message, {"nope": 1})
        with pytest.raises(TypeError, match="expected to be a dictionary but is a int"):
            set_message_fields(message, {"header": 3})
        return message

    message = point(use)
    assert message.header.frame_id == "base"
    assert list(message.joint_names) == ["a"]
    assert [list(each.positions) for each in message.points] == [[0.5], []]
    assert message.points[0].time_from_start.sec == 7


def test_stamps_may_be_set_later(point):
    def use(message):
        from builtin_interfaces.msg import Time
        from rosidl_runtime_py import set_message_fields

        (setter,) = set_message_fields(message, {"header": "auto"}, expand_header_auto=True)
        setter(Time(sec=9))
        (setter,) = set_message_fields(message.header, {"stamp": "now"}, expand_time_now=True)
        assert message.header.stamp.sec == 9
        setter(Time(sec=10))
        return message.header.stamp.sec

    assert point(use) == 10


def test_classes_are_found_by_name(run_ros2):
    def main():
        from control_msgs.action import GripperCommand
        from rosidl_runtime_py.utilities import (
            get_action,
            get_interface,
            get_message,
            get_service,
            is_action,
        )
        from std_msgs.msg import String
        from std_srvs.srv import Trigger

        assert get_message("std_msgs/msg/String") is get_message("std_msgs/String") is String
        assert get_service("std_srvs/srv/Trigger") is Trigger
        assert get_action("control_msgs/GripperCommand") is GripperCommand
        assert get_interface("std_srvs/srv/Trigger") is Trigger
        assert is_action(GripperCommand)
        assert not is_action(Trigger)
        with pytest.raises(ValueError, match="Expected the full name of a message"):
            get_message("std_srvs/srv/Trigger")
        with pytest.raises(AttributeError, match="Strings"):
            get_message("std_msgs/msg/Strings")

    run_ros2(main)
