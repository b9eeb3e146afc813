"""ROS 2 message classes: what rosidl's generated classes do.

Source: ros2/rosidl_python `rosidl_generator_py/resource/_msg.py.em`, and its
`test_interfaces.py`.
"""

import array
import copy
import pickle

import numpy as np
import pytest

from tracerisk.errors import InputError
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.interface_texts import InterfaceText
from tracerisk.ros.messages.ros2 import Interfaces2, copy_message, snake_case


@pytest.fixture(scope="module")
def interfaces():
    return Interfaces2()


@pytest.fixture
def point(interfaces):
    return interfaces.message("trajectory_msgs/JointTrajectoryPoint")()


def refused(assign):
    with pytest.raises(AssertionError) as caught:
        assign()
    return str(caught.value)


def test_the_constructor_takes_keywords_only(interfaces):
    pose = interfaces.message("geometry_msgs/Pose")
    with pytest.raises(TypeError):
        pose(1)
    assert refused(lambda: pose(z=1, x=2)) == "Invalid arguments passed to constructor: x, z"


def test_defaults_of_the_definition_hold(interfaces):
    pose = interfaces.message("geometry_msgs/PoseStamped")()
    assert pose.pose.orientation.w == 1.0
    assert pose.header.frame_id == ""
    assert not hasattr(pose.header, "seq")
    assert (pose.header.stamp.sec, pose.header.stamp.nanosec) == (0, 0)
    assert interfaces.message("control_msgs/MotionPrimitive")().type == -1


def test_defaults_of_arrays_are_words_numbers_and_bytes(tmp_path):
    (tmp_path / "msg").mkdir()
    (tmp_path / "msg" / "Plan.msg").write_text(
        'bool[2] is_open [true, false]\nbyte[2] bits [1, 255]\nstring[] names ["a b", "true"]\n'
    )
    plan = Interfaces2({"arm_msgs": tmp_path}).message("arm_msgs/Plan")()
    assert plan.is_open == [True, False]
    assert plan.bits == [b"\x01", b"\xff"]
    assert plan.names == ["a b", "true"]
    (tmp_path / "msg" / "Plan.msg").write_text("bool[2] is_open [true, maybe]\n")
    with pytest.raises(InputError, match="no default that a field can have"):
        Interfaces2({"arm_msgs": tmp_path}).message("arm_msgs/Plan")


def test_a_scalar_of_the_wrong_type_is_refused_in_rosidls_words(interfaces):
    pose = interfaces.message("geometry_msgs/PoseStamped")()

    def assign(target, name, value):
        return refused(lambda: setattr(target, name, value))

    assert assign(pose.pose.position, "x", 1) == "The 'x' field must be of type 'float'"
    assert assign(pose, "pose", 1) == "The 'pose' field must be a sub message of type 'Pose'"
    assert assign(pose.header, "frame_id", b"a") == "The 'frame_id' field must be of type 'str'"
    assert assign(pose.header.stamp, "sec", 1.0) == "The 'sec' field must be of type 'int'"
    assert (
        assign(pose.header.stamp, "sec", 2**31)
        == "The 'sec' field must be an integer in [-2147483648, 2147483647]"
    )
    assert (
        assign(pose.header.stamp, "nanosec", -1)
        == "The 'nanosec' field must be an unsigned integer in [0, 4294967295]"
    )
    small = interfaces.message("std_msgs/Float32")()
    assert (
        assign(small, "data", 1e39)
        == "The 'data' field must be a float in [-3.402823466e+38, 3.402823466e+38]"
    )
    small.data = float("inf")
    flag = interfaces.message("std_msgs/Bool")()
    assert assign(flag, "data", 1) == "The 'data' field must be of type 'bool'"
    byte = interfaces.message("std_msgs/Byte")()
    assert (
        assign(byte, "data", 1)
        == "The 'data' field must be of type 'bytes' or 'ByteString' with length 1"
    )


def test_sequences_of_numbers_are_arrays_of_python(point):
    point.positions = (1.0, 2.0)
    assert point.positions == array.array("d", [1.0, 2.0])
    point.positions.append(3)
    assert list(point.positions) == [1.0, 2.0, 3.0]
    reported = refused(lambda: setattr(point, "positions", ["1"]))
    assert reported.startswith(
        "The 'positions' field must be a set or sequence and each value of type 'float' and each "
        "double in [-1797693134862315"
    )
    for several in ([1, 2.0], np.array([1.0, 2.0]), np.array([1, 2]), np.zeros((2, 2))):
        assert "'positions' field" in refused(
            lambda given=several: setattr(point, "positions", given)
        )
    assert (
        refused(lambda: setattr(point, "positions", array.array("f")))
        == "The 'positions' array.array() must have the type code of 'd'"
    )


def test_the_constructor_packs_numbers_without_a_check(interfaces):
    made = interfaces.message("trajectory_msgs/JointTrajectoryPoint")(positions=[0, np.float64(1)])
    assert made.positions == array.array("d", [0.0, 1.0])


def test_fixed_arrays_of_numbers_are_numpys(interfaces):
    info = interfaces.message("sensor_msgs/CameraInfo")()
    assert info.k.dtype == np.float64
    assert info.k.tolist() == [0.0] * 9
    info.k = [1.0] * 9
    assert isinstance(info.k, np.ndarray)
    assert "with length 9 and each value of type 'float'" in refused(
        lambda: setattr(info, "k", [1.0])
    )
    assert (
        refused(lambda: setattr(info, "k", np.zeros(9, dtype=np.float32)))
        == "The 'k' numpy.ndarray() must have the dtype of 'numpy.float64'"
    )
    assert (
        refused(lambda: setattr(info, "k", np.zeros(4)))
        == "The 'k' numpy.ndarray() must have a size of 9"
    )


def test_sequences_of_others_are_kept_as_they_are(interfaces):
    state = interfaces.message("sensor_msgs/JointState")()
    names = ["a", "b"]
    state.name = names
    assert state.name is names
    assert (
        refused(lambda: setattr(state, "name", ["a", 1]))
        == "The 'name' field must be a set or sequence and each value of type 'str'"
    )
    refused(lambda: setattr(state, "name", "ab"))


def test_a_bounded_sequence_refuses_what_is_too_long(interfaces):
    solid = interfaces.message("shape_msgs/SolidPrimitive")()
    solid.dimensions = [0.1, 0.2, 0.3]
    assert "with length <= 3" in refused(lambda: setattr(solid, "dimensions", [0.1] * 4))
    assert (solid.BOX, type(solid).CYLINDER) == (1, 3)


def test_a_name_that_is_no_field_cannot_be_set(point):
    with pytest.raises(AttributeError):
        point.position = [1.0]


def test_types_of_the_fields_are_reported_as_idl_has_them(interfaces):
    kind = interfaces.message("sensor_msgs/JointState")
    assert kind.get_fields_and_field_types() == {
        "header": "std_msgs/Header",
        "name": "sequence<string>",
        "position": "sequence<double>",
        "velocity": "sequence<double>",
        "effort": "sequence<double>",
    }
    solid = interfaces.message("shape_msgs/SolidPrimitive").get_fields_and_field_types()
    assert solid["dimensions"] == "sequence<double, 3>"
    info = interfaces.message("sensor_msgs/CameraInfo").get_fields_and_field_types()
    assert info["k"] == "double[9]"


def test_messages_print_as_they_are_written(interfaces, point):
    point.positions = [1.0]
    point.time_from_start.sec = 2
    assert repr(point) == (
        "trajectory_msgs.msg.JointTrajectoryPoint(positions=[1.0], velocities=[], "
        "accelerations=[], effort=[], "
        "time_from_start=builtin_interfaces.msg.Duration(sec=2, nanosec=0))"
    )


def test_messages_compare_by_value_and_have_no_hash(interfaces):
    kind = interfaces.message("sensor_msgs/CameraInfo")
    one, other = kind(), kind()
    assert one == other
    other.k[0] = 1.0
    assert one != other
    assert one != "x"
    with pytest.raises(TypeError):
        hash(one)


def test_copies_and_pickles_are_equal_and_apart(interfaces):
    state = interfaces.message("sensor_msgs/JointState")(name=["a"], position=[1.0])
    for made in (copy.deepcopy(state), copy_message(state)):
        assert made == state
        made.position[0] = 2.0
        made.header.frame_id = "b"
        assert (state.position[0], state.header.frame_id) == (1.0, "")
    assert copy.copy(state).position is state.position
    with StandInFinder(interfaces):
        assert pickle.loads(pickle.dumps(state)) == state


def test_services_and_actions_hold_their_parts():
    with StandInFinder(Interfaces2()):
        from control_msgs.action import FollowJointTrajectory
        from control_msgs.action._gripper_command import GripperCommand, GripperCommand_Goal
        from geometry_msgs.msg._pose_stamped import PoseStamped
        from std_srvs.srv import SetBool

        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = ["a"]
        assert FollowJointTrajectory.Result.SUCCESSFUL == 0
        assert FollowJointTrajectory.Result().GOAL_TOLERANCE_VIOLATED == -5
        assert GripperCommand.Goal is GripperCommand_Goal
        assert GripperCommand.Goal().command.max_effort == 0.0
        assert SetBool.Request(data=True).data is True
        assert SetBool.Response().message == ""
        assert type(goal).__name__ == "FollowJointTrajectory_Goal"
        assert PoseStamped.__module__ == "geometry_msgs.msg._pose_stamped"
        with pytest.raises(NotImplementedError, match="can not be instantiated"):
            SetBool()
        with pytest.raises(ImportError, match=r"control_msgs\.action has no 'FollowJoint'"):
            from control_msgs.action import FollowJoint  # noqa: F401


def test_what_is_not_known_is_an_error_that_lists_what_is(interfaces):
    with pytest.raises(InputError, match="no message package 'nope_msgs'"):
        interfaces.message("nope_msgs/A")
    with pytest.raises(InputError, match=r"std_msgs has no message 'Strin'.*String"):
        interfaces.message("std_msgs/Strin")
    with pytest.raises(InputError, match=r"std_srvs has no service 'Trig'.*Trigger"):
        interfaces.service("std_srvs/Trig")
    with pytest.raises(InputError, match="control_msgs has no action 'Gripper'"):
        interfaces.action("control_msgs/Gripper")


def test_a_workspace_brings_its_own_interfaces(tmp_path):
    for kind, name, text in (
        ("msg", "Cup", 'string<=4 label "tea"\nfloat64[] heights [0.1, 2]\nuint8 BIG=7\n'),
        ("srv", "Fill", "Cup cup\n---\nbool ok\n"),
        ("action", "Pour", "Cup cup\nfloat32 speed 0.5\n---\nbool done true\n---\nwstring at\n"),
    ):
        (tmp_path / kind).mkdir()
        (tmp_path / kind / f"{name}.{kind}").write_text(text)
    own = Interfaces2({"cup_interfaces": tmp_path})
    cup = own.message("cup_interfaces/Cup")
    assert (cup().label, list(cup().heights), cup.BIG) == ("tea", [0.1, 2.0], 7)
    assert "not longer than 4" in refused(lambda: cup(label="coffee"))
    assert own.service("cup_interfaces/Fill").Request(cup=cup(label="a")).cup.label == "a"
    pour = own.action("cup_interfaces/Pour")
    assert (pour.Goal().speed, pour.Result().done, pour.Feedback().at) == (0.5, True, "")
    assert isinstance(pour.Goal().cup, cup)


def test_modules_are_named_as_rosidl_does():
    names = ["PoseStamped", "TFMessage", "GetPositionIK", "JointState", "Float64MultiArray"]
    assert [snake_case(name) for name in names] == [
        "pose_stamped",
        "tf_message",
        "get_position_ik",
        "joint_state",
        "float64_multi_array",
    ]


def test_a_field_that_is_guessed_holds_what_the_program_gives_it():
    interfaces = Interfaces2(rules=DistroRules("humble"))
    text = "float64 width\nfloat64[] steps\ngeometry_msgs/Pose place\n"
    interfaces.also([InterfaceText("rg_msgs", "msg", "Output", text)])
    output = interfaces.message("rg_msgs/Output")
    message = output(steps=["a"])
    message.width, message.place = 400, (1, 2)
    sent = copy_message(message)
    assert (sent.width, list(sent.steps), sent.place) == (400, ["a"], (1, 2))
    assert output().place.position.x == 0.0
    with pytest.raises(AssertionError):
        interfaces.message("std_msgs/Float64")(data=400)
