"""Each mistake in a scenario is told with its place and with what is allowed."""

import textwrap
from types import SimpleNamespace

import pytest

from tracerisk.errors import ScenarioError
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.parameter_files import read_parameters
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.objects import with_objects, with_start
from tracerisk.ros.scenario.world import ScenarioWorld
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot


def give(path, interfaces):
    """Read a scenario and give its world to a run on the Panda, as the command does."""
    scenario = read_scenario(path)
    with_objects(load_scene("tube_racks"), scenario.objects)
    with_start(load_robot("panda"), scenario.start)
    scheduler = Scheduler(SimpleNamespace(time_ns=0, busy=False), duration_ns=1)
    robot = SimpleNamespace(link_names=("panda_hand",))
    runtime = Runtime(scheduler, Graph(scheduler), twin=SimpleNamespace(robot=robot))
    ScenarioWorld(runtime, interfaces, scenario)


@pytest.fixture
def error_of(tmp_path):
    """The message of the error that a scenario gives, without its folder."""

    def error_of(text, interfaces=None):
        path = tmp_path / "s.yaml"
        path.write_text(textwrap.dedent(text))
        with pytest.raises(ScenarioError) as error:
            give(path, interfaces or Interfaces())
        return str(error.value).removeprefix(f"{tmp_path}/")

    return error_of


POINT = "publish:\n  - topic: /p\n    type: geometry_msgs/PointStamped\n    message: {}\n"
BODY = "objects:\n  - name: cube\n    box: [0.1, 0.1, 0.1]\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "service:\n  - {name: /a}\n",
            "s.yaml:1:1: unknown key 'service'; did you mean 'services'?",
        ),
        (
            "services:\n  - name: /a\n    replys: 1\n",
            "s.yaml:3:5: unknown key 'replys' in services[0]; did you mean 'reply'?",
        ),
        ("services: 3\n", "s.yaml:1:1: services: expected a list, found the number 3"),
        (
            "services:\n  - {name: /a}\n  - {name: /a}\n",
            "s.yaml:3:6: services[1].name: duplicate '/a' in services",
        ),
        (
            "services:\n  - {name: /a, type: std_srvs/Triger}\n",
            "s.yaml:2:16: std_srvs has no service 'Triger'; did you mean 'Trigger'?",
        ),
        (
            "services:\n  - {name: /a, type: Trigger}\n",
            "expected a type such as geometry_msgs/PoseStamped",
        ),
        (
            "services:\n  - {name: /a, fails: no, reply: {}}\n",
            "a service that fails gives no reply; keep one of the two",
        ),
        (
            "services:\n  - {name: /a, reply: {}, replies: [{}]}\n",
            "stands beside 'reply'; keep one of the two",
        ),
        ("services:\n  - {name: ~a}\n", "expected the full name, such as /camera/detections"),
        (
            POINT.replace("{}", "{point: {w: 1}}"),
            "s.yaml:4:23: publish[0].message.point.w: geometry_msgs/Point has no field 'w'; "
            "allowed: x, y, z",
        ),
        (
            POINT.replace("{}", "{point: {x: one}}"),
            "s.yaml:4:23: publish[0].message.point.x: expected a number for float64, found 'one'",
        ),
        (
            POINT.replace("{}", "{header: {stamp: noon}}"),
            "expected 'now', seconds or their parts, found 'noon'",
        ),
        (
            POINT.replace("{}", "3"),
            "expected a mapping of the fields of geometry_msgs/PointStamped, found '3'",
        ),
        (
            "publish:\n  - {topic: /a, type: std_msgs/UInt8, message: 300}\n",
            "300 does not fit uint8; allowed: 0 to 255",
        ),
        (
            "publish:\n  - {topic: /a, type: std_msgs/String, message: 3}\n",
            "expected a string, found '3'; put it in quotes",
        ),
        (
            "publish:\n  - {topic: /a, type: std_msgs/Bool, message: 1}\n",
            "expected true or false, found '1'",
        ),
        (
            "publish:\n  - {topic: /a, type: sensor_msgs/JointState, message: {name: a}}\n",
            "publish[0].message.name: expected a list for string[], found 'a'",
        ),
        (
            "publish:\n  - {topic: /a, type: visualization_msgs/Marker, message: {type: CUB}}\n",
            "found 'CUB'; did you mean 'CUBE'?",
        ),
        (
            "publish:\n  - {topic: /a, type: std_msgs/Bool, rate: 2, at: [1, 2]}\n",
            "give either a rate or several times",
        ),
        (
            "publish:\n  - {topic: /a, type: std_msgs/Bool, until: 2}\n",
            "says when a rate ends; give a rate, or leave it out",
        ),
        (
            "publish:\n  - {topic: /a, type: std_msgs/Bool, at: 2, after: 1}\n",
            "counts from when a subscriber appears; leave out at and rate",
        ),
        (
            "publish:\n  - {topic: /a, type: std_msgs/Bool, rate: 1, when: /b}\n",
            "says what a message answers; leave out at and rate",
        ),
        (
            "publish:\n  - {topic: /a, type: std_msgs/Bool, at: [2, 1]}\n",
            "expected times from 0 up that rise",
        ),
        (
            "publish:\n  - {topic: /a, type: std_msgs/Bool, messages: []}\n",
            "expected a list of one or more",
        ),
        (
            "actions:\n  - {name: /a, type: move_base_msgs/MoveBase, status: suceeded}\n",
            "'suceeded' is no outcome; did you mean 'succeeded'?",
        ),
        (
            "actions:\n  - {name: /a, type: move_base_msgs/MoveBas}\n",
            "move_base_msgs has no message 'MoveBasResult'; did you mean 'MoveBaseResult'?",
        ),
        (
            "actions:\n  - {name: /a, type: a/B, after: 1, goals: [{}]}\n",
            "stands in each entry of goals where goals is given",
        ),
        ("actions:\n  - {name: /a, type: a/B, goals: []}\n", "holds no goal"),
        (
            "frames:\n  - {frame: panda_hand, parent: world}\n",
            "s.yaml:2:6: frame 'panda_hand' is a link of the robot",
        ),
        (
            "frames:\n  - {frame: a, parent: world, path: [{at: 1}, {at: 1}]}\n",
            "expected places with rising times (at)",
        ),
        (
            "frames:\n  - {frame: a, parent: world, xyz: [1, 2, 3], path: [{at: 1}]}\n",
            "stands in each entry of path where a path is given",
        ),
        (
            "frames:\n  - {frame: a, parent: world, until: 3}\n",
            "a static frame stays; give it a rate, or leave it out",
        ),
        (
            "calls:\n  - {service: /a, action: /b, type: a/B}\n",
            "s.yaml:2:5: expected exactly one of service and action",
        ),
        (
            "calls:\n  - {service: /a, type: std_srvs/SetBool, goal: {}}\n",
            "unknown key 'goal' in calls[0]; allowed: at, request, service, type",
        ),
        (
            "calls:\n  - {service: /a, type: std_srvs/SetBool, request: {dat: true}}\n",
            "calls[0].request.dat: std_srvs/SetBoolRequest has no field 'dat'; did you mean 'data'?",
        ),
        (
            "calls:\n  - {action: /a, type: move_base_msgs/MoveBas}\n",
            "move_base_msgs has no message 'MoveBasGoal'; did you mean 'MoveBaseGoal'?",
        ),
        ("answers: yes\n", "expected a list, one answer for each input()"),
        ("answers: [true]\n", "expected strings or numbers, found True; put it in quotes"),
        ("parameters: {a: }\n", "s.yaml:1:14: parameters.a: has no value; give it one"),
        ("parameters: {a: 99999999999}\n", "cannot hold a whole number of more than 32 bits"),
        (BODY.replace("cube", "table"), "the scene has a 'table' already; take another name"),
        (BODY + "    sphere: {radius: 1}\n", "expected exactly one of box, cylinder and sphere"),
        (BODY.replace("box: [0.1, 0.1, 0.1]", "xyz: [0, 0, 0]"), "expected exactly one of box"),
        (BODY.replace("[0.1, 0.1, 0.1]", "[0.1, 0.1, 0]"), "every length must be above 0"),
        (BODY + "    graspable: true\n", "'mass' is missing in objects[0]; give it one"),
        (
            "start: {panda_joint9: 0.1}\n",
            "s.yaml:1:9: robot 'panda' has no joint 'panda_joint9'; did",
        ),
        ("start: {panda_joint1: 9}\n", "9 for joint 'panda_joint1' is outside its limits [-2.8973"),
        ("start: {panda_joint1: up}\n", "start.panda_joint1: expected a number"),
        (BODY + "    known: true\n    mass: 1\n", "unknown key 'mass' in objects[0]"),
        (BODY + "    known: false\n    attached: hand\n", "is known to the planning scene"),
        (
            "calls:\n  - {service: /a, type: std_srvs/SetBool, wait: -1}\n",
            "calls[0].wait: -1 is outside",
        ),
        (
            BODY + "    graspable: false\n    mass: 1\n",
            "is only for what can be grasped; set graspable: true",
        ),
    ],
)
def test_a_mistake_is_reported_with_its_place(error_of, text, expected):
    assert expected in error_of(text)


def test_wrong_fields_of_ros_2_are_reported_alike(error_of):
    text = "publish:\n  - topic: /j\n    type: sensor_msgs/CameraInfo\n    message: {k: [1, 2]}\n"
    assert "s.yaml:4:15: publish[0].message.k: expected 9 values for float64[9], found 2" in (
        error_of(text, Interfaces2())
    )


def test_a_scenario_that_is_not_there_is_reported(tmp_path):
    with pytest.raises(ScenarioError, match="cannot be read: No such file"):
        read_scenario(tmp_path / "missing.yaml")


def test_a_parameter_file_is_reported_of_with_its_line(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("/**:\n  ros__parameters:\n    speed:\n")
    with pytest.raises(ScenarioError, match=r"p.yaml:3:5: .*speed: has no value"):
        read_parameters(path)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a: 1\nb: !!set {x, z}\n", "p.yaml:2:1: b: cannot hold a set (!!set); allowed: true or"),
        ("a: {b: [1, !!set {x}]}\n", "p.yaml:1:5: a.b: cannot hold a set (!!set); allowed: "),
        ("a: 2001-01-01\n", "p.yaml:1:1: a: cannot hold the date 2001-01-01; put it in quotes"),
        ("a: 9999999999\n", "p.yaml:1:1: a: cannot hold a whole number of more than 32 bits; "),
        ("a: !mine b\n", "p.yaml:1:1: a: cannot hold a value of the type !mine; allowed: "),
        ("a: [1, null]\n", "p.yaml:1:1: a: cannot hold an entry without a value; allowed: "),
    ],
)
def test_what_no_parameter_of_a_file_can_be_is_reported_with_what_can(tmp_path, text, expected):
    path = tmp_path / "p.yaml"
    path.write_text(text)
    with pytest.raises(ScenarioError) as error:
        read_parameters(path)
    assert str(error.value).removeprefix(f"{tmp_path}/").startswith(expected)
