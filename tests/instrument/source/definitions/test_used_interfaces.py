"""Definitions that are not here, as a program uses them."""

import ast

import pytest

from tracerisk.instrument.source.definitions.used_interfaces import (
    imports_interfaces,
    used_definitions,
)
from tracerisk.ros.messages.ros1 import Interfaces

KNOWN = Interfaces()


def _defined(source, package="own_msgs"):
    def known(name, kind):
        return KNOWN.module_names(name, kind) if name in KNOWN.packages else ()

    texts = used_definitions(
        [ast.parse(source)], package, known, is_ros1="import rclpy" not in source
    )
    return {f"{kind}/{name}": text.split("\n") for (kind, name), text in texts.items()}


@pytest.mark.parametrize(
    ("use", "line"),
    [
        ("target = Target()\ntarget.joints = [0.1, 0.2]", "float64[] joints"),
        ("Target(speed=3)", "float64 speed"),
        ("Target(label='home')", "string label"),
        ("t = Target()\nt.grip = True", "bool grip"),
        ("t = Target()\nt.pose = PoseStamped()", "geometry_msgs/PoseStamped pose"),
        ("t = Target()\nt.header.frame_id = 'base'", "std_msgs/Header header"),
        ("t = Target()\nt.names.append('left')", "string[] names"),
        ("t = Target()\nt.goal.position.x = 0.3", "geometry_msgs/Pose goal"),
        ("def take(m):\n    go(m.angles[0])\nrospy.Subscriber('/t', Target, take)", "float64[] angles"),
        ("def take(m: Target):\n    if m.mode == 'fast':\n        pass", "string mode"),
        ("def take(m):\n    for i in range(m.count):\n        pass\n"
         "rospy.Subscriber('/t', Target, callback=take)", "int64 count"),
        ("t = Target()\nt.rates = [0.8] * 6\n", "float64[] rates"),
        ("t = Target()\nt.speed = [0.8] * count\n", "float64[] speed"),
        ("class A:\n    _t = Target()\n    def go(self):\n        self._t.steps.append(1)",
         "float64[] steps"),
        ("PLACES = ['a', 'b']\ndef take(m: Target):\n    go(PLACES[m.number])", "int64 number"),
        ("PLACES = {'a': 1}\ndef take(m: Target):\n    go(PLACES[m.place])", "string place"),
        ("PLACES = load()\ndef take(m: Target):\n    go(PLACES[m.place])", "float64 place"),
        ("class A:\n    def __init__(self):\n        self.t = Target()\n"
         "    def go(self):\n        self.t.name = f'{1}'", "string name"),
        ("m = rospy.wait_for_message('/t', Target)\nif not m.ready:\n    pass", "bool ready"),
    ],
)  # fmt: skip
def test_the_fields_of_a_message_are_those_that_a_program_uses(use, line):
    head = "import rospy\nfrom own_msgs.msg import Target\nfrom geometry_msgs.msg import *\n"
    head += "from geometry_msgs.msg import PoseStamped\n"
    assert line in _defined(head + use)["msg/Target"]


def test_parts_of_the_same_fields_are_of_one_type():
    defined = _defined(
        "from own_msgs.msg import Arms\n"
        "def take(m: Arms):\n    return [m.joint1.at, m.joint1.speed, m.joint2.at, m.joint2.speed]\n"
    )
    assert defined["msg/ArmsJoint"] == ["float64 at", "float64 speed", ""]
    assert "own_msgs/ArmsJoint joint2" in defined["msg/Arms"]


@pytest.mark.parametrize(
    "source",
    [
        "import rospy\nfrom own_msgs.srv import Pick, PickResponse\n"
        "pick = rospy.ServiceProxy('/pick', Pick)\nif pick(label='cup').success:\n    pass\n",
        "import rospy\nfrom own_msgs.srv import Pick\n"
        "if not rospy.ServiceProxy('/pick', service_class=Pick)(label='cup').success:\n    pass\n",
        "import rospy\nfrom own_msgs.srv import *\n"
        "def answer(request):\n    print(request.label.upper())\n"
        "    return PickResponse(success=True)\nrospy.Service('/pick', Pick, answer)\n",
        "import rospy, own_msgs.srv\n"
        "def answer(request):\n    print(request.label.upper())\n"
        "    return own_msgs.srv.PickResponse(success=True)\n"
        "rospy.Service('/pick', own_msgs.srv.Pick, answer)\n",
        "import rclpy\nfrom own_msgs.srv import Pick\n"
        "client = node.create_client(Pick, '/pick')\nrequest = Pick.Request()\n"
        "request.label = 'cup'\nfuture = client.call_async(request)\n"
        "if future.result().success is True:\n    pass\n",
        "import rclpy\nfrom own_msgs import srv\n"
        "def answer(request, response):\n    response.success = request.label == 'cup'\n"
        "    return response\nnode.create_service(srv.Pick, '/pick', answer)\n",
    ],
)
def test_a_service_has_the_parts_that_are_sent_and_read(source):
    assert _defined(source) == {"srv/Pick": ["string label", "---", "bool success", ""]}


def test_messages_of_an_action_of_ros_1_are_parts_of_it():
    defined = _defined(
        "import actionlib\nfrom own_msgs.msg import MoveAction, MoveGoal\n"
        "client = actionlib.SimpleActionClient('/move', MoveAction)\n"
        "client.send_goal(MoveGoal(height=0.2))\nprint(len(client.get_result().points))\n"
    )
    lines = ["float64 height", "---", "float64[] points", "---", "", ""]
    assert defined == {"action/Move": lines}


def test_values_without_a_name_have_a_field_each():
    defined = _defined("from own_msgs.msg import Pair\nPair(1.0, 'left')\n")
    assert defined["msg/Pair"] == ["float64 value_0", "string value_1", ""]


def test_of_names_that_are_imported_all_at_once_those_of_other_packages_are_left_out():
    defined = _defined(
        "from own_msgs.msg import *\nfrom std_msgs.msg import *\n"
        "class Mine:\n    pass\nString()\nMine()\nThing(width=0.1)\n"
    )
    assert defined == {"msg/Thing": ["float64 width", ""]}


def test_whole_numbers_are_whole_in_ros_2():
    source = "import rclpy\nfrom own_msgs.msg import Thing\nThing(number=3)\n"
    assert _defined(source)["msg/Thing"] == ["int64 number", ""]


@pytest.mark.parametrize(
    ("imported", "expected"),
    [
        ([["own", "msg"]], True),
        ([["own", "msg"], ["own", "srv"], ["numpy"]], True),
        ([["own", "msg"], ["own", "tools"]], False),
        ([["own"]], False),
        ([["numpy"]], False),
    ],
)
def test_a_package_of_definitions_is_one_of_which_nothing_else_is_imported(imported, expected):
    assert imports_interfaces(imported, "own") is expected
