from __future__ import annotations

import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.detect import detect_robot

UR_JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint"]


@pytest.mark.parametrize(
    "strings",
    [
        ["panda_arm", "hand"],
        ["panda_joint1", "hello"],
        ["/panda_arm_controller/follow_joint_trajectory"],
        ["panda_joint"],
        ["moving panda_link8 up"],
        ["franka"],
    ],
)
def test_the_panda_is_known_by_its_names(strings: list[str]):
    assert detect_robot(strings).name == "panda"


@pytest.mark.parametrize("strings", [[], ["gripper", "hand"], ["joint", "expanda_arms"]])
def test_strings_that_name_no_robot_are_an_error(strings: list[str]):
    with pytest.raises(RobotError, match=r"name no joint, link or group.*--robot"):
        detect_robot(strings)


def test_joints_that_several_robots_have_are_an_error_that_lists_them():
    with pytest.raises(RobotError, match=r"fit several robots: ur10, ur10e, ur3, ur3e, ur5, ur5e"):
        detect_robot(UR_JOINTS)


@pytest.mark.parametrize(
    ("strings", "place"),
    [
        ([*UR_JOINTS, "ur5e"], ""),
        ([*UR_JOINTS, "package://ur5e/meshes"], ""),
        (UR_JOINTS, "ur5e_moveit_config/scripts/pick.py"),
        (UR_JOINTS, "my-ur5e/pick.py"),
        (UR_JOINTS, "src/UR5e_pick/pick.py"),
    ],
)
def test_a_name_in_strings_or_path_decides_between_them(strings: list[str], place: str):
    assert detect_robot(strings, place).name == "ur5e"


def test_a_longer_name_is_no_mention_of_a_shorter_one():
    assert detect_robot([*UR_JOINTS, "ur5"]).name == "ur5"
    with pytest.raises(RobotError, match="fit several robots"):
        detect_robot([*UR_JOINTS, "ur5x", "sur5"])


def test_two_names_leave_it_open():
    with pytest.raises(RobotError, match=r"fit several robots: ur3, ur5;"):
        detect_robot([*UR_JOINTS, "ur3", "ur5"])


def test_joints_speak_louder_than_a_name():
    assert detect_robot(["panda_joint1", "ur5e"]).name == "panda"
