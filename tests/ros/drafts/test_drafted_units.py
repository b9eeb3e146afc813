"""Drafted numbers are in the units that names, comments, docstrings and code say."""

import pytest

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.drafts.named_numbers import SI, Units, units_said
from tracerisk.ros.drafts.posture_numbers import numbers_of
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.robot import load_robot

PER_RADIAN = 57.29577951308232


@pytest.fixture(scope="module")
def values():
    robot = load_robot("panda")
    kinematics = Kinematics(robot)
    return UsableValues(robot, kinematics.forward, kinematics.inverse)


def in_degrees(values) -> list[float]:
    return [round(each * PER_RADIAN, 1) for each in values.posture]


@pytest.mark.parametrize(
    ("text", "units"),
    [
        ("angle in degrees", Units(PER_RADIAN)),
        ("turn by 30 deg", Units(PER_RADIAN)),
        ("yaw = math.radians(msg.yaw)", Units(PER_RADIAN)),
        ("q = msg.data * math.pi / 180", Units(PER_RADIAN)),
        ("height_mm", Units(1.0, 1000.0)),
        ("x = msg.x / 1000.0", Units(1.0, 1000.0)),
        ("z = msg.z * 0.001", Units(1.0, 1000.0)),
        ("given in cm", Units(1.0, 100.0)),
        ("joints [deg], positions [mm]", Units(PER_RADIAN, 1000.0)),
        # What goes out is no unit of what comes in.
        ("print(math.degrees(msg.yaw), 'degrees')", SI),
        ("rospy.loginfo(x * 1000, 'mm')", SI),
        ("in radians and metres", SI),
        ("command, comm, degenerate", SI),
    ],
)
def test_units_that_are_said(text, units):
    assert units_said(text) == units


CALLBACKS = '''\
import math, rospy

def in_code(msg):
    arm.go([math.radians(each) for each in msg.data])

def in_docstring(msg):
    """Move to joints that are given in degrees."""
    arm.go(msg.data)

def in_comment(msg):
    arm.go(msg.data)  # [deg]

def plain(msg):
    """Move to joints, 7 of them."""
    arm.go(msg.data)

def point(msg):
    goal = [msg.x / 1000.0, msg.y / 1000.0, msg.z / 1000.0]

def in_metres(msg):
    """Move there; the gripper opens 80 mm."""
    goal = [msg.x, msg.y, msg.z]

rospy.Subscriber("/a", Float64MultiArray, in_code)
rospy.Subscriber("/b", Float64MultiArray, in_docstring)
rospy.Subscriber("/c", Float64MultiArray, callback=in_comment)
rospy.Subscriber("/d", Float64MultiArray, plain)
rospy.Subscriber("/e", Point, point)
rospy.Subscriber("/f", Point, in_metres)
rospy.get_param("~yaw_deg") + 1.0
rospy.get_param("~goal_z") + 1.0  # in mm
rospy.get_param("~goal_x") + 1.0
float(rospy.get_param("~goal_y"))
float(input("Angle of the first joint in degrees: "))
x, y, z = [float(each) for each in input("x y z [mm]: ").split()]
'''


@pytest.fixture
def message(values, tmp_path):
    path = tmp_path / "c.py"
    path.write_text(CALLBACKS)

    def drafted(kind, name, type_name=""):
        lines = CALLBACKS.splitlines()
        line = next(number for number, text in enumerate(lines, 1) if f'"{name}' in text)
        missed = Missed(Need(kind, name, type_name), 0, 0, Location(str(path), line))
        (draft,) = drafts([missed], Interfaces(), values)
        return draft.value

    return drafted


@pytest.mark.parametrize("topic", ["/a", "/b", "/c"])
def test_joints_are_in_degrees_where_the_callback_says_so(message, values, topic):
    drafted = message("topic", topic, "std_msgs/Float64MultiArray")
    assert drafted["message"]["data"] == in_degrees(values)


def test_joints_are_in_radians_where_nothing_is_said(message, values):
    drafted = message("topic", "/d", "std_msgs/Float64MultiArray")
    assert drafted["message"]["data"] == list(values.posture)


def test_a_point_is_in_metres_unless_the_code_converts_it(message, values):
    x, y, z = values.pose.position
    assert message("topic", "/f", "geometry_msgs/Point")["message"] == {"x": x, "y": y, "z": z}
    found = message("topic", "/e", "geometry_msgs/Point")["message"]
    assert found == {"x": round(x * 1000, 4), "y": round(y * 1000, 4), "z": round(z * 1000, 4)}


def test_a_parameter_that_is_a_place_is_reached_in_its_unit(message, values):
    assert message("parameter", "~goal_x") == values.pose.position[0]
    assert message("parameter", "~goal_y") == values.pose.position[1]
    assert message("parameter", "~goal_z") == round(values.pose.position[2] * 1000, 4)
    assert message("parameter", "~yaw_deg") == round(values.reach.turn[2] * PER_RADIAN, 1)


def test_answers_are_in_the_units_of_the_question(message, values):
    assert message("input", "Angle of the first joint in degrees") == ["11.5"]
    x, y, z = (1000 * each for each in values.pose.position)
    assert message("input", "x y z [mm]") == [f"{x:.4g} {y:.4g} {z:.4g}"]


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        ("float64[7] joints  # [deg]", {"joints": "degrees"}),
        ("float64[7] joints_deg", {"joints_deg": "degrees"}),
        ("float64[7] joints", {"joints": "radians"}),
        ("float64 x # mm\nfloat64 j2 # degrees", {"x": "mm", "j2": "joint"}),
    ],
)
def test_the_definition_of_a_message_says_units(values, tmp_path, text, fields):
    (tmp_path / "cell" / "msg").mkdir(parents=True)
    (tmp_path / "cell" / "msg" / "Order.msg").write_text(f"{text}\n")
    made = Interfaces2(workspace={"cell": tmp_path / "cell"})
    (draft,) = drafts([Missed(Need("topic", "/order", "cell/Order"), 0, 0, None)], made, values)
    degrees = in_degrees(values)
    meant = {
        "degrees": degrees,
        "radians": list(values.posture),
        "mm": round(values.pose.position[0] * 1000, 4),
        "joint": degrees[1],
    }
    assert draft.value["message"] == {name: meant[kind] for name, kind in fields.items()}


@pytest.mark.parametrize(("package", "per_metre"), [("cell", 1000.0), ("others", 1.0)])
def test_a_pose_in_a_drivers_message_is_in_the_drivers_units(tmp_path, package, per_metre):
    robot = load_robot("panda")
    kinematics = Kinematics(robot)
    values = UsableValues(robot, kinematics.forward, kinematics.inverse)
    values.units_of_packages = {"cell": Units(1.0, 1000.0)}
    (tmp_path / "srv").mkdir()
    (tmp_path / "srv" / "Move.srv").write_text("float32[] pose\nfloat64 x\nfloat64 y_cm\n---\n")
    made = Interfaces2(workspace={package: tmp_path})
    missed = Missed(Need("call", "/move", f"{package}/Move"), 0, 0, None)
    (draft,) = drafts([missed], made, values)
    x, y, z = (round(per_metre * metres, 4) for metres in values.pose.position)
    request = draft.value["request"]
    assert request["pose"][:3] == [x, y, z]
    assert request["pose"][3:] == pytest.approx(values.reach.turn, abs=1e-4)
    # What the field itself says goes first.
    assert (request["x"], request["y_cm"]) == (x, round(100 * values.pose.position[1], 4))


TIMES = {
    "a wait": ("float32 timeout_sec", {"timeout_sec": 60.0}),
    "a wait in milliseconds": ("float32 timeout_ms", {"timeout_ms": 60000.0}),
    "a wait in whole numbers": (
        "int32 timeout_ms\nuint8 timeout\nint8 move_time_ms",
        {"timeout_ms": 60000, "timeout": 60, "move_time_ms": 1},
    ),
    "a motion": ("float64 duration\nfloat64 move_time", {"duration": 3.0, "move_time": 3.0}),
    "a length": ("float64 distance", {"distance": 0.1}),
}


@pytest.mark.parametrize("kind", TIMES)
def test_a_time_is_long_enough_for_a_motion(values, tmp_path, kind):
    text, fields = TIMES[kind]
    folder = tmp_path / "cell" / "srv"
    folder.mkdir(parents=True)
    (folder / "Go.srv").write_text(f"{text}\n---\nbool ok\n")
    interfaces = Interfaces2(workspace={"cell": tmp_path / "cell"})
    (draft,) = drafts([Missed(Need("call", "/go", "cell/Go"), 0, 0, None)], interfaces, values)
    assert draft.value["request"] == fields


def test_a_matrix_is_that_of_a_pose(values):
    x, y, z = values.pose.position
    by_rows = numbers_of("transform_matrix", 16, values.posture, values.pose)
    by_columns = numbers_of("O_T_EE", 16, values.posture, values.pose)
    assert (by_rows[3::4], by_columns[12:]) == ([x, y, z, 1.0], [x, y, z, 1.0])
    assert by_rows[1] == by_columns[4]
    assert numbers_of("NE_T_EE", 16, values.posture, values.pose)[:6] == [1, 0, 0, 0, 0, 1]
    assert numbers_of("stiffness", 16, values.posture, values.pose) == []


@pytest.mark.parametrize("name", ["approach", "surface_normal", "approaches_filtered"])
def test_a_direction_is_upwards(values, name):
    assert numbers_of(name, 3, values.posture, values.pose) == [0.0, 0.0, 1.0]
    assert numbers_of("approach_point", 3, values.posture, values.pose) == list(
        values.pose.position
    )
