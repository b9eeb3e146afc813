"""Drafts pass the checks before what moves the robot: modes, fields, lengths, ranges, order."""

import math

import pytest

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.ros.drafts.drafting import drafts, drafts_instead
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.robot import load_robot

NODE = '''\
class Cell(Node):
    def __init__(self):
        self.declare_parameter("mode", "zero")
        self.declare_parameter("dry_run", True)
        self.declare_parameter("follow", False)
        self.declare_parameter("planner", "ompl")
        self.declare_parameter("frame", "world")
        self.mode = str(self.get_parameter("mode").value)
        self.create_subscription(Float64MultiArray, "/joints", self.on_joints, 10)
        self.create_subscription(PoseArray, "/places", self.on_places, 10)
        self.create_subscription(Float64, "/width", self.on_width, 10)
        self.create_subscription(Int32, "/step", self.on_step, 10)
        self.create_subscription(Order, "/order", self.on_order, 10)
        self.create_subscription(JointState, "/servos", self.on_servos, 10)
        self.create_subscription(JointTrajectory, "/path", self.on_path, 10)
        self.create_subscription(JointState, "/radians", self.on_radians, 10)
        if self.get_parameter("frame").value.endswith(".urdf"):
            load()

    def on_joints(self, msg):
        if self.mode not in ("zero", "topic"):
            raise ValueError(self.mode)
        if len(msg.data) != 8:
            self.get_logger().error("8 numbers")
            return
        self.move(msg.data)

    def on_places(self, msg):
        if len(msg.poses) < 2:
            return
        self.pick(msg.poses[0], msg.poses[1])

    def on_width(self, msg):
        if msg.data < 0.0 or msg.data > 0.05:
            return
        self.grip(msg.data)

    def on_step(self, msg):
        if self.state == 0 and msg.data == 1:
            self.state = 1
        elif self.state == 1 and msg.data == 2:
            self.move(self.goal)

    def on_order(self, msg):
        if self.state == "idle" and msg.command == "prepare":
            self.state = "ready"
        elif self.state == "ready" and msg.command == "execute":
            self.move(self.goal)

    def on_servos(self, msg):
        self.move([servo_degrees_to_position(each) for each in msg.position])

    def on_path(self, msg):
        """Take a path whose positions are in degrees."""
        self.move(msg.points[0].positions)

    def on_radians(self, msg):
        self.move(msg.position)
'''


@pytest.fixture(scope="module")
def values():
    robot = load_robot("panda")
    kinematics = Kinematics(robot)
    return UsableValues(robot, kinematics.forward, kinematics.inverse)


@pytest.fixture
def node(tmp_path):
    (tmp_path / "cell" / "msg").mkdir(parents=True)
    (tmp_path / "cell" / "msg" / "Order.msg").write_text("string command\nint32 priority\n")
    file = tmp_path / "node.py"
    file.write_text(NODE)
    return file


def missed(node, kind, name, type_name):
    line = next(at for at, text in enumerate(NODE.splitlines(), 1) if f'"{name}"' in text)
    return Missed(Need(kind, name, type_name), 0, 0, Location(str(node), line))


def topic(node, values, name, type_name):
    interfaces = Interfaces2(workspace={"cell": node.parent / "cell"})
    (draft,) = drafts([missed(node, "topic", name, type_name)], interfaces, values)
    return draft.value


@pytest.mark.parametrize(
    ("name", "default", "other"),
    [
        ("mode", "zero", ["topic"]),
        ("dry_run", True, [False]),
        ("follow", False, [True]),
        ("planner", "ompl", []),
        ("frame", "world", []),
    ],
)
def test_a_parameter_with_which_nothing_moves_gets_another_value(node, name, default, other):
    found = list(drafts_instead([(missed(node, "parameter", name, ""), default)]))
    assert [each.value for each in found] == other
    assert all(each.is_instead and str(default) in each.words for each in found)


def test_a_list_has_as_many_numbers_as_the_callback_asks(node, values):
    data = topic(node, values, "/joints", "std_msgs/Float64MultiArray")["message"]["data"]
    assert data == [*values.posture, 0.0]


def test_a_list_has_as_many_poses_as_the_callback_asks_at_least(node, values):
    assert len(topic(node, values, "/places", "geometry_msgs/PoseArray")["message"]["poses"]) == 2


def test_a_number_is_within_the_range_that_is_not_refused(node, values):
    assert topic(node, values, "/width", "std_msgs/Float64")["message"] == {"data": 0.025}


@pytest.mark.parametrize(
    ("name", "type_name", "field", "known"),
    [
        ("/step", "std_msgs/Int32", "data", [1, 2]),
        ("/order", "cell/Order", "command", ["prepare", "execute"]),
    ],
)
def test_each_value_that_a_state_machine_knows_comes_in_turn(
    node, values, name, type_name, field, known
):
    sent = topic(node, values, name, type_name)
    assert [message[field] for message in sent["messages"]] == known


@pytest.mark.parametrize(
    ("name", "type_name", "is_degrees"),
    [
        ("/servos", "sensor_msgs/JointState", True),
        ("/path", "trajectory_msgs/JointTrajectory", True),
        ("/radians", "sensor_msgs/JointState", False),
    ],
)
def test_joints_are_in_the_units_that_the_callback_says(node, values, name, type_name, is_degrees):
    sent = topic(node, values, name, type_name)["message"]
    drafted = sent["position"] if "position" in sent else sent["points"][0]["positions"]
    wanted = values.posture
    if is_degrees:
        wanted = [round(math.degrees(each), 1) for each in wanted]
    assert drafted[: len(wanted)] == list(wanted)


@pytest.mark.parametrize(
    ("asked", "called"),
    [
        (["/move", "/disable", "/enable"], ["/enable", "/move", "/disable"]),
        (["/stop", "/home", "/power_on"], ["/power_on", "/home", "/stop"]),
        (["/jog", "/arm/servo_off", "/arm/clear_error"],
         ["/arm/clear_error", "/jog", "/arm/servo_off"]),
        (["/pick", "/place"], ["/pick", "/place"]),
    ],
)  # fmt: skip
def test_what_enables_is_called_first_and_what_disables_last(values, asked, called):
    needs = [Missed(Need("call", name, "std_srvs/Trigger"), 0, 0, None) for name in asked]
    found = drafts(needs, Interfaces2(workspace={}), values)
    assert [each.key for each in found] == called
