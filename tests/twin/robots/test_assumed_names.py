from dataclasses import replace

from tracerisk.twin.robots.assumed_names import with_assumed_names
from tracerisk.twin.robots.robot import load_robot


def test_an_arm_that_is_not_known_is_the_one_without_its_hand():
    reported: list[str] = []
    panda = with_assumed_names(replace(load_robot("panda"), assumes_names=True), reported.append)
    assert panda.groups["arm"] == panda.groups["panda_arm"]
    assert panda.groups["gripper"] == panda.groups["hand"]
    assert len(reported) == 2


def test_a_misspelt_group_is_not_assumed():
    reported: list[str] = []
    panda = with_assumed_names(replace(load_robot("panda"), assumes_names=True), reported.append)
    assert "panda_arn" not in panda.groups
    assert "manipulator" in panda.groups
    assert "panda_arm_group" in panda.groups  # longer than a known one is another one


def test_a_robot_of_which_every_group_is_a_grippers_moves_as_that_gripper():
    panda = load_robot("panda")
    hand = replace(panda, groups={"hand": panda.groups["hand"]}, assumes_names=True)
    found = with_assumed_names(hand, lambda _: None)
    assert found.groups["arm"] == panda.groups["hand"]


def test_a_robot_without_groups_assumes_none():
    bare = replace(load_robot("panda"), groups={}, named_states={}, assumes_names=True)
    found = with_assumed_names(bare, lambda _: None)
    assert "arm" not in found.groups
    assert not list(found.named_states.values())


def test_a_group_that_is_not_known_has_the_joints_of_the_controller_of_its_name():
    reported: list[str] = []
    joints = tuple(f"panda_joint{number}" for number in range(1, 5))
    panda = with_assumed_names(
        replace(load_robot("panda"), assumes_names=True),
        reported.append,
        lambda: {
            "digger_controller": joints[::-1],
            "others": joints[:2],
            "hand_controller": ("panda_finger_joint1", "panda_finger_joint2"),
        },
    )
    assert panda.groups["digger"].joints == joints
    assert panda.groups["digger"].tip_link == "panda_link4"
    assert panda.groups["manipulator"] == panda.groups["panda_arm"]  # nobody says which
    assert panda.groups["gripper"] == panda.groups["hand"]
    assert "using the joints of controller digger_controller of panda" in reported[0]


def test_a_group_that_is_not_known_is_what_the_only_controller_of_several_joints_moves():
    joints = ("panda_joint1", "panda_joint3")
    panda = with_assumed_names(
        replace(load_robot("panda"), assumes_names=True), lambda _: None, lambda: {"a": joints}
    )
    assert panda.groups["manipulator"].joints == joints
