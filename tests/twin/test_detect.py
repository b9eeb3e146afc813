from __future__ import annotations

import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.detect import NoRobotNamedError, SeveralRobotsError, detect_robot
from tracerisk.twin.robots.index import shipped_names
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.robots.robot_names import Hint, decide, mentioned

UR_JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint"]
SIX = [f"joint{i}" for i in range(1, 7)]
ROBOTS = {each.name: each for each in shipped_names()}


def source(text: str) -> list[Hint]:
    return [Hint("its source", {"pick.py": text}, is_telling=True)]


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


@pytest.mark.parametrize(
    "strings",
    [
        [],
        ["gripper", "hand"],
        ["joint", "expanda_arms"],
        ["gripper_controller", "gripper_left_joint"],
        ["base", "manipulator", "tool0"],
        ["right_arm", "left_arm"],
        ["elbow_joint"],
        ["fetch the cup", "fetch"],
        SIX,
    ],
)
def test_strings_that_any_robot_could_have_name_none(strings: list[str]):
    with pytest.raises(NoRobotNamedError, match=r"name no joint, link or group.*--robot"):
        detect_robot(strings)


def test_joints_that_several_robots_have_are_an_error_that_lists_them():
    with pytest.raises(
        SeveralRobotsError,
        match=r"fit several robots: ur10, ur10e, ur3, ur3e, ur5, ur5e; say .*--r",
    ):
        detect_robot(UR_JOINTS)


@pytest.mark.parametrize(
    "text", ["ur5e", "package://ur5e/meshes", "my-UR5e", "class UR5eArm", "UR 5e"]
)
def test_a_name_in_a_hint_decides_between_them(text: str):
    robot = detect_robot(UR_JOINTS, source(text))
    assert robot.name == "ur5e"
    assert robot.chosen_by == (
        "inferred from the names in the controller's strings; ur5e is named in its source (pick.py)"
    )


def test_a_longer_name_is_no_mention_of_a_shorter_one():
    assert detect_robot(UR_JOINTS, source("ur5")).name == "ur5"
    with pytest.raises(RobotError, match="fit several robots"):
        detect_robot(UR_JOINTS, source("ur5x sur5"))


def test_two_names_of_one_weight_leave_it_open_between_these():
    with pytest.raises(RobotError, match=r"fit several robots: ur3, ur5;"):
        detect_robot(UR_JOINTS, source("ur3 or ur5"))
    lighter = Hint("a readme", {"README.md": "for the UR5"})
    assert detect_robot(UR_JOINTS, [*source("ur3 or ur5"), lighter]).name == "ur5"


def test_the_heavier_hint_decides():
    lighter = Hint("a readme", {"README.md": "for the UR10"})
    assert detect_robot(UR_JOINTS, [*source("ur3"), lighter]).name == "ur3"


def test_a_list_of_all_variants_is_no_vote_and_contradicting_files_decide_nothing():
    launch = Hint("a launch file", {"a.launch": "ur3 ur5 ur10", "b.launch": "ur5"})
    assert detect_robot(UR_JOINTS, [launch]).name == "ur5"
    torn = Hint("a launch file", {"a.launch": "ur3", "b.launch": "ur5"})
    with pytest.raises(RobotError, match="fit several robots: ur3, ur5;"):
        detect_robot(UR_JOINTS, [torn])


def test_joints_speak_louder_than_a_name():
    assert detect_robot(["panda_joint1", "ur5e"], source("ur5e")).name == "panda"


def test_the_only_robot_without_further_joints_is_meant_by_a_whole_list():
    joints = ["waist", "shoulder", "elbow", "wrist_angle"]
    robot = detect_robot(joints)
    assert robot.name == "px100"
    assert "only px100 has no joint beside these" in robot.chosen_by
    assert detect_robot(joints, source("wx250s")).name == "wx250s"


def test_numbered_joints_need_a_name():
    assert detect_robot(SIX, source("xArm6")).name == "xarm6"
    assert detect_robot(SIX, [Hint("a readme", {"README.md": "the xArm 6"})]).name == "xarm6"
    with pytest.raises(NoRobotNamedError):
        detect_robot(SIX, source("ur5e"))  # it has no such joints


def test_a_robot_that_is_named_alone_assumes_the_groups_it_lacks():
    robot = detect_robot(["manipulator"], source("UR10e"))
    assert robot.name == "ur10e"
    assert robot.assumes_names
    assert detect_robot([], source("baxter_interface")).name == "baxter"
    with pytest.raises(NoRobotNamedError):
        detect_robot(["manipulator"], [Hint("a readme", {"README.md": "as on the UR10e"})])


def test_names_may_be_built_of_a_prefix_and_a_joint():
    strings = ["panda_", *(f"joint{i}" for i in range(1, 8)), "link0"]
    assert detect_robot(strings, source("import panda")).name == "panda"
    with pytest.raises(NoRobotNamedError):
        detect_robot([*strings[1:], "arm_"])


def test_groups_are_assumed_where_none_of_the_robots_own_is_named():
    assert detect_robot(["panda_joint1", "arm"]).assumes_names
    assert not detect_robot(["panda_joint1", "panda_arm", "arm"]).assumes_names


def test_a_named_robot_without_the_listed_joints_is_not_taken():
    with pytest.raises(NoRobotNamedError):
        detect_robot(["arm_lift", "arm_turn"], source("ur10e"), ["arm_lift", "arm_turn"])


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("franka_fr3 arm", {"fr3"}),
        ("the Franka", {"panda"}),
        ("franka fr3, franka fr3", {"fr3"}),
        ("Niryo Ned2", {"niryo_ned2"}),
        ("OpenManipulator-X, xarm7", {"open_manipulator_x", "xarm7"}),
        ("myCobot 280", {"mycobot_280"}),
        ("PX-100 (px100)", {"px100"}),
        ("fetch the part", set()),
        ("fetch_robot", {"fetch"}),
    ],
)
def test_mentions_are_whole_words_in_any_spelling(text: str, names: set[str]):
    assert mentioned(text, ROBOTS) == names


def test_hints_that_say_nothing_leave_all():
    verdict = decide(["ur3", "ur5"], ROBOTS, [Hint("its comments", {"a.py": "an arm"})])
    assert verdict.left == ("ur3", "ur5")
    assert not verdict.reason


def test_a_name_that_two_robots_share_speaks_for_the_one_whose_joints_are_named():
    hints = [Hint("its folders", {"src": "iiwa14_pick"})]
    assert detect_robot(["iiwa_joint_1"], hints).name == "iiwa14_stack"
    assert detect_robot(["lbr_A1"], hints).name == "iiwa14"


def test_a_prefix_before_all_joints_of_an_arm_is_before_its_links_too():
    joints = [f"left_{name}" for name in (*UR_JOINTS, "wrist_2_joint", "wrist_3_joint")]
    robot = detect_robot([*joints, "left_tool0"], source("ur5e"), joints)
    assert robot.name == "ur5e"
    assert [joint.name for joint in robot.arm_joints] == [
        "left_shoulder_pan_joint", "left_shoulder_lift_joint", "left_elbow_joint",
        "left_wrist_1_joint", "left_wrist_2_joint", "left_wrist_3_joint",
    ]  # fmt: skip
    assert robot.groups["manipulator"].tip_link == "left_tool0"
    assert robot.chosen_by.endswith("its links and joints have the prefix 'left_'")
    pose = Kinematics(robot).forward({}, "left_tool0")
    assert pose == Kinematics(load_robot("ur5e")).forward({}, "tool0")
    with pytest.raises(SeveralRobotsError):
        detect_robot(joints)


def test_joints_with_two_prefixes_are_of_two_arms_which_no_robot_has():
    joints = [*UR_JOINTS, "wrist_2_joint", "wrist_3_joint"]
    both = [f"{side}_{name}" for side in ("left", "right") for name in joints]
    with pytest.raises(NoRobotNamedError):
        detect_robot(both, source("ur5e"), both)
