import copy
import pickle
import subprocess
import sys
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from tracerisk.errors import InputError
from tracerisk.ros.messages.ros1 import Interfaces, SerializationError
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.time.rostime import Duration, Time


@pytest.fixture(scope="module")
def interfaces() -> Interfaces:
    return Interfaces()


@pytest.fixture(scope="module")
def pose(interfaces):
    return interfaces.message("geometry_msgs/Pose")


@pytest.fixture(scope="module")
def stamped(interfaces):
    return interfaces.message("geometry_msgs/PoseStamped")


def test_every_field_has_its_ros_default(interfaces, stamped):
    message = stamped()
    assert message.pose.orientation.w == 0.0
    assert (message.header.seq, message.header.frame_id) == (0, "")
    assert message.header.stamp == Time(0, 0)
    assert interfaces.message("geometry_msgs/PoseWithCovariance")().covariance == [0.0] * 36
    assert interfaces.message("sensor_msgs/JointState")().position == []
    assert interfaces.message("sensor_msgs/Image")().data == b""
    assert interfaces.message("std_msgs/Bool")().data is False
    assert interfaces.message("moveit_msgs/Grasp")().pre_grasp_posture.points == []
    goal = interfaces.message("control_msgs/FollowJointTrajectoryGoal")()
    assert goal.goal_time_tolerance == Duration(0)


def test_defaults_are_not_shared(pose):
    one, other = pose(), pose()
    one.position.x = 3.0
    assert other.position.x == 0.0


def test_all_values_may_be_given_in_order(interfaces):
    point = interfaces.message("geometry_msgs/Point")(1.0, 2.0, 3.0)
    assert (point.x, point.y, point.z) == (1.0, 2.0, 3.0)


def test_some_values_may_be_given_by_name(interfaces):
    point = interfaces.message("geometry_msgs/Point")(z=3.0)
    assert (point.x, point.y, point.z) == (0.0, 0.0, 3.0)


def test_none_stands_for_the_default(pose):
    assert pose(position=None).position.x == 0.0


def test_too_few_values_are_a_type_error(pose):
    with pytest.raises(
        TypeError,
        match=r"Invalid number of arguments, args should be \['position', 'orientation'\]",
    ):
        pose(1.0)


def test_values_in_order_and_by_name_exclude_each_other(pose):
    with pytest.raises(TypeError, match="may only use args OR keywords, not both"):
        pose(1.0, orientation=None)


def test_an_unknown_keyword_is_an_attribute_error(pose):
    with pytest.raises(AttributeError, match=r"^pos is not an attribute of Pose$"):
        pose(pos=1)


def test_an_unknown_field_cannot_be_set(pose):
    with pytest.raises(AttributeError, match="'Pose' object has no attribute 'psition'"):
        pose().psition = 1


def test_constants_are_class_attributes(interfaces):
    codes = interfaces.message("moveit_msgs/MoveItErrorCodes")
    assert (codes.SUCCESS, codes.NO_IK_SOLUTION, codes.FAILURE) == (1, -31, 99999)
    assert codes().SUCCESS == 1
    assert interfaces.message("visualization_msgs/Marker").CUBE == 1


def test_messages_are_equal_by_value_and_lists_equal_tuples(interfaces, pose):
    state = interfaces.message("sensor_msgs/JointState")
    assert pose() == pose()
    assert state(position=[1.0, 2.0]) == state(position=(1.0, 2.0))
    assert state(position=[1.0]) != state(position=[2.0])
    assert pose() != interfaces.message("geometry_msgs/Point")()


def test_a_message_has_no_hash(pose):
    with pytest.raises(TypeError, match="unhashable"):
        hash(pose())


def test_a_deep_copy_is_apart_and_a_copy_is_not(stamped):
    first = stamped()
    shallow, deep = copy.copy(first), copy.deepcopy(first)
    first.pose.position.x = 1.0
    assert (shallow.pose.position.x, deep.pose.position.x) == (1.0, 0.0)


def test_printing_gives_yaml(stamped):
    message = stamped()
    message.header.frame_id = "panda_link0"
    message.header.stamp = Time(3, 20)
    message.pose.orientation.w = 1.0
    assert str(message) == (
        "header: \n"
        "  seq: 0\n"
        "  stamp: \n"
        "    secs: 3\n"
        "    nsecs:        20\n"
        '  frame_id: "panda_link0"\n'
        "pose: \n"
        "  position: \n"
        "    x: 0.0\n"
        "    y: 0.0\n"
        "    z: 0.0\n"
        "  orientation: \n"
        "    x: 0.0\n"
        "    y: 0.0\n"
        "    z: 0.0\n"
        "    w: 1.0"
    )
    assert repr(message) == str(message)


def test_printing_shows_lists_of_numbers_strings_and_messages(interfaces):
    point = interfaces.message("trajectory_msgs/JointTrajectoryPoint")(positions=[1.0, 2.0])
    trajectory = interfaces.message("trajectory_msgs/JointTrajectory")(
        joint_names=["a", "no"], points=[point]
    )
    text = str(trajectory)
    assert "joint_names: \n  - a\n  - 'no'\n" in text
    assert "points: \n  - \n    positions: [1.0, 2.0]\n    velocities: []\n" in text


@pytest.mark.parametrize(
    ("name", "md5"),
    [
        ("geometry_msgs/Pose", "e45d45a5a1ce597b249e23fb30fc871f"),
        ("geometry_msgs/PoseStamped", "d3812c3cbc69362b77dc0b19b345f8f5"),
        ("std_msgs/Header", "2176decaecbce78abc3b96ef049fabed"),
        ("std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1"),
        ("std_msgs/Empty", "d41d8cd98f00b204e9800998ecf8427e"),
        ("sensor_msgs/JointState", "3066dcd76a6cfaef579bd0f34173e9fd"),
        ("control_msgs/FollowJointTrajectoryAction", "bc4f9b743838566551c0390c65f1a248"),
    ],
)
def test_the_md5_sum_is_that_of_ros(interfaces, name, md5):
    assert interfaces.message(name)._md5sum == md5


@pytest.mark.parametrize(
    ("name", "md5"),
    [
        ("std_srvs/SetBool", "09fb03525b03e7ea1fd3992bafd87e16"),
        ("std_srvs/Trigger", "937c9679a518e3a18d831e57125ea522"),
        ("std_srvs/Empty", "d41d8cd98f00b204e9800998ecf8427e"),
    ],
)
def test_the_md5_sum_of_a_service_is_that_of_ros(interfaces, name, md5):
    assert interfaces.service(name)._md5sum == md5


def test_a_service_has_a_request_and_a_response(interfaces):
    service = interfaces.service("moveit_msgs/GetPositionIK")
    assert service._request_class is interfaces.message("moveit_msgs/GetPositionIKRequest")
    assert service._request_class().ik_request.group_name == ""
    assert service._response_class().error_code.val == 0


def test_an_action_makes_seven_messages(interfaces):
    names = [n for n in interfaces.message_names("move_base_msgs") if n.startswith("MoveBase")]
    parts = ("Action", "ActionFeedback", "ActionGoal", "ActionResult", "Feedback", "Goal", "Result")
    assert names == [f"MoveBase{part}" for part in parts]
    goal = interfaces.message("move_base_msgs/MoveBaseActionGoal")()
    assert goal.goal_id._type == "actionlib_msgs/GoalID"
    assert goal.goal == interfaces.message("move_base_msgs/MoveBaseGoal")()


def test_every_known_interface_can_be_made(interfaces):
    for package in interfaces.packages:
        for name in interfaces.message_names(package):
            message = interfaces.message(f"{package}/{name}")
            assert message()._type == f"{package}/{name}"
        for name in interfaces.service_names(package):
            assert interfaces.service(f"{package}/{name}")._request_class is not None


def test_a_class_is_made_once(interfaces, pose):
    assert interfaces.message("geometry_msgs/Pose") is pose
    assert type(interfaces.message("geometry_msgs/PoseStamped")().pose) is pose


def test_an_unknown_message_names_the_nearest(interfaces):
    with pytest.raises(
        InputError, match="geometry_msgs has no message 'Posee'; did you mean 'Pose'"
    ):
        interfaces.message("geometry_msgs/Posee")


def test_an_unknown_package_lists_those_known(interfaces):
    with pytest.raises(InputError, match=r"no message package 'foo_msgs'.*geometry_msgs"):
        interfaces.message("foo_msgs/Foo")


def test_a_workspace_brings_its_own_messages(tmp_path: Path):
    folder = tmp_path / "my_msgs"
    (folder / "msg").mkdir(parents=True)
    (folder / "msg" / "Grip.msg").write_text(
        "# a grip\nuint8 OPEN=0\nuint8 CLOSE=1\nuint8 command\ngeometry_msgs/Pose[] poses\n"
    )
    own = Interfaces({"my_msgs": folder})
    grip = own.message("my_msgs/Grip")
    assert (grip.CLOSE, grip().poses) == (1, [])
    assert grip._slot_types == ["uint8", "geometry_msgs/Pose[]"]


def test_a_malformed_text_names_the_file(tmp_path: Path):
    folder = tmp_path / "my_msgs"
    (folder / "msg").mkdir(parents=True)
    (folder / "msg" / "Bad.msg").write_text("float64 x\n!!\n")
    with pytest.raises(InputError, match=r"Bad\.msg: not a message definition"):
        Interfaces({"my_msgs": folder}).message("my_msgs/Bad")


def test_an_unknown_field_type_names_the_field(tmp_path: Path):
    folder = tmp_path / "my_msgs"
    (folder / "msg").mkdir(parents=True)
    (folder / "msg" / "Bad.msg").write_text("foo_msgs/Foo thing\n")
    with pytest.raises(InputError, match="field 'thing' of my_msgs/Bad: no message package"):
        Interfaces({"my_msgs": folder}).message("my_msgs/Bad")


OF_EITHER_ROS = pytest.mark.parametrize(
    "make", [Interfaces, lambda own: Interfaces2(workspace=own)]
)


@OF_EITHER_ROS
@pytest.mark.parametrize(
    "text",
    [
        "Arm_Interface/Pos__Rot tip\nstring mode",
        "Pos__Rot tip\nstring mode\n",
        "\ufeffPos__Rot tip\nstring mode\n",
        "# a tip\r\n\r\nPos__Rot\ttip\t# where it is\r\nstring mode#its mode\r\n",
    ],
)
def test_names_and_line_ends_are_read_as_ros_reads_them(tmp_path: Path, make, text):
    folder = tmp_path / "Arm_Interface" / "msg"
    folder.mkdir(parents=True)
    (folder / "Pos__Rot.msg").write_text("float64 x\n")
    (folder / "State.msg").write_bytes(text.encode())
    state = make({"Arm_Interface": folder.parent}).message("Arm_Interface/State")()
    assert (state.tip.x, state.mode) == (0.0, "")


@OF_EITHER_ROS
def test_comments_that_are_not_utf_8_are_passed_over(tmp_path: Path, make):
    folder = tmp_path / "my_msgs"
    for kind, text in (("msg", b"float64 x # 20 \xb0C\n"), ("srv", b"# \xe4\n---\nbool ok\n")):
        (folder / kind).mkdir(parents=True)
        (folder / kind / f"Warm.{kind}").write_bytes(text)
    interfaces = make({"my_msgs": folder})
    assert interfaces.message("my_msgs/Warm")().x == 0.0
    assert interfaces.service("my_msgs/Warm") is not None


def test_a_service_text_without_two_parts_is_refused(tmp_path: Path):
    folder = tmp_path / "my_msgs"
    (folder / "srv").mkdir(parents=True)
    (folder / "srv" / "Bad.srv").write_text("float64 x\n")
    with pytest.raises(InputError, match=r"Bad\.srv: 1 parts between lines '---', 2 expected"):
        Interfaces({"my_msgs": folder}).service("my_msgs/Bad")


def check_message(message):
    """Write a message, as sending does."""
    message.serialize(BytesIO())


@pytest.mark.parametrize(
    ("name", "values", "text"),
    [
        ("geometry_msgs/Point", {"x": "1"}, "field x must be float type"),
        ("geometry_msgs/Pose", {"position": 3}, r"field position must be of type \[geometry_msgs/Point\]"),
        ("std_msgs/Int32", {"data": 1.5}, "field data must be an integer type"),
        ("std_msgs/Int32", {"data": 2**31}, r"field data exceeds specified width \[int32\]"),
        ("std_msgs/UInt16", {"data": -1}, "field data must be unsigned integer type"),
        ("std_msgs/UInt16", {"data": 2**16}, r"field data exceeds specified width \[uint16\]"),
        ("std_msgs/Bool", {"data": "yes"}, "field data is not a bool"),
        ("std_msgs/String", {"data": 7}, "field data must be of type bytes or an ascii string"),
        ("std_msgs/Time", {"data": 7}, "field data must be of type Time"),
        ("std_msgs/Duration", {"data": 7}, "field data must be of type Duration"),
        ("sensor_msgs/JointState", {"position": 7}, "field position must be a list or tuple type"),
        ("sensor_msgs/JointState", {"position": ["a"]}, r"field position\[\] must be float type"),
        ("sensor_msgs/JointState", {"position": "ab"}, r"Only uint8\[\] can be a string"),
        ("sensor_msgs/JointState", {"name": [3]}, r"field name\[\] must be of type bytes"),
        ("geometry_msgs/PoseWithCovariance", {"covariance": [0.0]}, "field covariance must have 36 elements instead of 1"),
    ],
)  # fmt: skip
def test_a_value_of_the_wrong_type_cannot_be_sent(interfaces, name, values, text):
    with pytest.raises(SerializationError, match=text):
        check_message(interfaces.message(name)(**values))


def test_a_nested_value_of_the_wrong_type_is_named_with_its_path(stamped):
    message = stamped()
    message.pose.position.x = "far"
    with pytest.raises(SerializationError, match=r"^field pose\.position\.x must be float type$"):
        check_message(message)


def test_what_the_real_library_sends_passes(interfaces):
    state = interfaces.message("sensor_msgs/JointState")
    check_message(state(position=np.zeros(3), velocity=(1, 2), effort=[np.float32(1.0)]))
    check_message(interfaces.message("std_msgs/Int32")(data=np.int64(3)))
    marker = interfaces.message("visualization_msgs/Marker")()
    marker.scale = interfaces.message("geometry_msgs/Point")(1.0, 1.0, 1.0)
    check_message(marker)


def test_a_message_can_be_pickled_where_its_module_is_served(stamped):
    from tracerisk.ros.imports.finder import StandInFinder

    finder = StandInFinder()
    with finder:
        message = finder.interfaces.message("geometry_msgs/PoseStamped")()
        message.pose.position.x = 2.0
        assert pickle.loads(pickle.dumps(message)) == message


def test_importing_the_messages_module_parses_nothing():
    code = (
        "import sys, tracerisk.ros.messages.ros1 as m; m.Interfaces();"
        "sys.exit(any(n.startswith('rosbags') for n in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Loop inner\n", "contains itself"),
        ("float/etc/passwd x\n", "message"),
        ("uint8 X=1\nuint8 X\n", "two of the name X"),
    ],
)
def test_a_text_that_makes_no_class_is_an_input_error(tmp_path, text, expected):
    (tmp_path / "msg").mkdir()
    (tmp_path / "msg" / "Loop.msg").write_text(text)
    with pytest.raises(InputError, match=expected):
        Interfaces({"odd": tmp_path}).message("odd/Loop")


def test_a_constant_of_text_is_all_that_follows_its_sign(tmp_path):
    (tmp_path / "msg").mkdir()
    (tmp_path / "msg" / "Words.msg").write_text(
        "string NOTHING= \n"
        "string QUOTED=\"hello\" 'there'\n"
        "string MARKED=#no comment, stripped  \n"
        "int32 count # string NONE=1\n"
    )
    words = Interfaces({"lab_msgs": tmp_path}).message("lab_msgs/Words")
    assert (words.NOTHING, words.QUOTED) == ("", "\"hello\" 'there'")
    assert words.MARKED == "#no comment, stripped"
    assert words.__slots__ == ["count"]
