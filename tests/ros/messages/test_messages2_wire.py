"""CDR of ROS 2 messages, against that of rosbags."""

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.messages.ros2_wire import decode, encode

STORE = get_typestore(Stores.ROS2_JAZZY)
INTERFACES = Interfaces2()


def theirs(message):
    """The same message as rosbags has it."""
    package, short = type(message)._ros_type.split("/")
    values = []
    for field in type(message)._ros_fields:
        value = getattr(message, field.name)
        if field.message is not None:
            many = field.arrangement != "scalar"
            value = [theirs(item) for item in value] if many else theirs(value)
        elif field.arrangement != "scalar" and field.base != "string":
            value = np.array(value, dtype=bool if field.base == "bool" else field.dtype)
        elif field.base == "byte":
            value = value[0]
        values.append(value)
    return STORE.types[f"{package}/msg/{short}"](*values)


def message(name, **fields):
    return INTERFACES.message(name)(**fields)


def pose():
    made = message("geometry_msgs/PoseStamped")
    made.header.frame_id, made.header.stamp.sec = "base", -7
    made.pose.position.x, made.pose.orientation.w = 0.25, 0.5
    return made


def trajectory():
    point = message("trajectory_msgs/JointTrajectoryPoint", positions=[0.1, -2.0], effort=[3.0])
    point.time_from_start.nanosec = 5
    return message(
        "trajectory_msgs/JointTrajectory", joint_names=["a", "bcd"], points=[point, point]
    )


MESSAGES = {
    "text": lambda: message("std_msgs/String", data="Grüße"),
    "no text": lambda: message("std_msgs/String"),
    "truth": lambda: message("std_msgs/Bool", data=True),
    "octet": lambda: message("std_msgs/Byte", data=b"\x07"),
    "wide number": lambda: message("std_msgs/Int64", data=-(2**40)),
    "empty": lambda: message("std_msgs/Empty"),
    "nested": pose,
    "sequences": trajectory,
    "array": lambda: message(
        "sensor_msgs/Imu", orientation_covariance=[float(i) for i in range(9)]
    ),
    "bytes": lambda: message(
        "sensor_msgs/Image", height=2, data=[1, 2, 3], encoding="mono8", step=1
    ),
    "after one byte": lambda: message("rcl_interfaces/ParameterValue", type=3, double_value=1.5),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_bytes_are_those_of_rosbags_and_lead_back(name):
    made = MESSAGES[name]()
    package, short = type(made)._ros_type.split("/")
    data = encode(made)
    expected = bytes(STORE.serialize_cdr(theirs(made), f"{package}/msg/{short}"))
    # Its writer leaves room for the longest padding at the end.
    assert data == expected[: len(data)]
    assert not any(expected[len(data) :])
    assert decode(data, type(made)) == made


def test_big_endian_is_read():
    made = message("std_msgs/Int32", data=5)
    assert decode(b"\x00\x00\x00\x00" + (5).to_bytes(4, "big"), type(made)) == made


@pytest.mark.parametrize("data", [b"", b"\x00\x01\x00\x00\x05\x00", b"\x03\x01\x00\x00aaaa"])
def test_what_is_no_message_is_an_error(data):
    with pytest.raises(ValueError, match="the data "):
        decode(data, INTERFACES.message("std_msgs/Int32"))
