"""The order in which drivers publish the states of joints."""

from types import SimpleNamespace

import pytest

from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.robot.state_order import StateOrder, unordered
from tracerisk.twin.robots.added_gripper import with_assumed_gripper
from tracerisk.twin.robots.robot import load_robot

UR = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
]
ALPHABETICAL = [*sorted(UR[:3]), *UR[3:]]


def published(distro: str, robot: str, packages=None, fingers=None) -> list[str]:
    model = load_robot(robot)
    if fingers is not None:
        model = with_assumed_gripper(model, fingers)
    names = tuple(joint.name for joint in model.joints)
    twin = SimpleNamespace(robot=model)
    runtime = Runtime(None, None, twin, packages=packages or {}, distro=DistroRules(distro))
    return [names[place] for place in runtime.client(StateOrder).places(names)]


@pytest.mark.parametrize(
    ("distro", "order"),
    [
        # What users of UR drivers report of ROS 1 (UniversalRobots/Universal_Robots_ROS_Driver
        # issue 619) and of Humble.
        ("noetic", ALPHABETICAL),
        ("humble", [*UR[1:], UR[0]]),
        ("jazzy", ALPHABETICAL),
    ],
)
def test_the_driver_of_a_ur_has_an_order_of_its_own(distro, order):
    assert published(distro, "ur5e") == order


def test_an_unordered_map_lists_joints_as_users_report_them():
    # kroshu/kuka_drivers issue 254.
    arm = [f"joint_{number}" for number in range(6, 0, -1)]
    assert unordered(arm) == [f"joint_{number}" for number in (1, 2, 4, 5, 3, 6)]


def test_an_unordered_map_grows_as_that_of_libstdcpp():
    # As a program listed it that was compiled by GCC 12.
    names = [f"left_arm_j{number}" for number in range(20, 0, -1)]
    order = (1, 2, 6, 5, 7, 20, 14, 4, 18, 17, 13, 3, 10, 15, 16, 12, 19, 11, 9, 8)
    assert unordered(names) == [f"left_arm_j{number}" for number in order]


@pytest.mark.parametrize("robot", ["px100", "baxter", "fetch"])
def test_drivers_that_are_none_of_ros_control_keep_their_order(robot):
    names = [joint.name for joint in load_robot(robot).joints]
    assert published("noetic", robot) == names != sorted(names)


@pytest.mark.parametrize(
    ("distro", "publisher"),
    [("noetic", "joint_state_controller"), ("jazzy", "joint_state_broadcaster")],
)
def test_joints_that_a_parameter_lists_come_as_listed(distro, publisher, tmp_path):
    listed = [UR[4], UR[0], UR[2]]
    (tmp_path / "controllers.yaml").write_text(f"{publisher}:\n  joints: [{', '.join(listed)}]\n")
    assert published(distro, "ur5e", {"cell": tmp_path})[:3] == listed


@pytest.mark.parametrize(("fingers", "more"), [([], []), (["finger_joint"], ["finger_joint"])])
def test_a_gripper_that_nobody_names_is_not_among_the_joints_of_the_arm(fingers, more):
    assert sorted(published("jazzy", "ur5e", fingers=fingers)) == sorted([*UR, *more])
