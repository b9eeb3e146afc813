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
