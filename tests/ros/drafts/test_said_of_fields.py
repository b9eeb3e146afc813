"""Drafts of fields that a name, a definition or a use of the source says something of."""

import pytest

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.robot import load_robot

NODE = """\
class Cell:
    def __init__(self):
        self.shelves = {}
        self.shelves["upper"] = [0.0, 0.1]
        rospy.Service("/step", Step, self.step)

    def step(self, request):
        self.put(self.shelves[request.shelf])
        self.arm.set_named_target(request.posture)
        self.gripper.set_named_target(request.grip)
        self.arm.set_pose_target(request.goal_position)
"""
STEP = """\
geometry_msgs/Vector3 goal_position
geometry_msgs/Vector3 goal_rpy
geometry_msgs/Vector3 max_force
string shelf
string posture
string grip
---
bool done
"""


@pytest.fixture(scope="module")
def values():
    robot = load_robot("panda")
    kinematics = Kinematics(robot)
    return UsableValues(robot, kinematics.forward, kinematics.inverse)


@pytest.fixture
def request_of(tmp_path, values):
    """Return what the drafted call of a service asks, by the text of its definition."""

    def request(text, interfaces):
        (tmp_path / "cell" / "srv").mkdir(parents=True)
        (tmp_path / "cell" / "srv" / "Step.srv").write_text(text)
        (tmp_path / "node.py").write_text(NODE)
        line = next(at for at, row in enumerate(NODE.splitlines(), 1) if '"/step"' in row)
        place = Location(str(tmp_path / "node.py"), line)
        need = Missed(Need("call", "/step", "cell/Step"), 0, 0, place)
        (draft, *_) = drafts([need], interfaces({"cell": tmp_path / "cell"}), values)
        return draft.value["request"]

    return request


def interfaces1(packages):
    return Interfaces(workspace=packages)


def interfaces2(packages):
    return Interfaces2(workspace=packages)


@pytest.mark.parametrize("interfaces", [interfaces1, interfaces2])
def test_a_vector_is_the_place_or_the_angles_that_its_name_says(request_of, values, interfaces):
    sent = request_of(STEP, interfaces)
    assert tuple(sent["goal_position"].values()) == values.pose.position
    assert tuple(sent["goal_rpy"].values()) == values.reach.turn
    assert tuple(sent["max_force"].values()) == (0.0, 0.0, 0.0)


def test_a_name_is_a_key_that_is_put_into_a_mapping_later(request_of):
    assert request_of(STEP, interfaces1)["shelf"] == "upper"


def test_a_name_that_is_given_to_a_group_is_one_of_its_states(request_of, values):
    sent, states = request_of(STEP, interfaces1), values.robot.named_states
    assert sent["posture"] in states["panda_arm"]
    assert sent["grip"] in states["hand"]


def test_a_field_has_the_default_of_its_definition(request_of):
    text = STEP.replace("string shelf", 'string shelf\nfloat64 speed 0.35\nstring tool "cup"')
    sent = request_of(text, interfaces2)
    assert (sent["speed"], sent["tool"]) == (0.35, "cup")
