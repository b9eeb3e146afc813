from dataclasses import replace

from tracerisk.ros.moveit.robot_groups import RobotGroups
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.robots.robot_parts import Group

FIRST, SECOND = "panda_finger_joint1", "panda_finger_joint2"


def test_a_list_for_a_gripper_may_have_the_fingers_that_follow():
    panda = load_robot("panda")
    lead = replace(panda, groups={**panda.groups, "lead": Group((FIRST,), None)})
    groups = RobotGroups(lead, 0)
    assert groups.values_by_name("hand", [0.01, 0.02]) == {FIRST: 0.01, SECOND: 0.02}
    assert groups.values_by_name("lead", [0.01]) == {FIRST: 0.01}
    assert groups.values_by_name("lead", [0.01, 0.02]) == {FIRST: 0.01}
    assert groups.values_by_name("lead", [0.01, 0.02, 0.03]) is None


def test_a_list_for_an_arm_has_a_value_for_each_joint():
    groups = RobotGroups(load_robot("panda"), 0)
    assert groups.values_by_name("panda_arm", [0.0] * 6) is None
    assert len(groups.values_by_name("panda_arm", [0.0] * 7) or ()) == 7


def test_a_group_whose_members_are_known_takes_as_many_values_as_it_has_variables():
    panda = load_robot("panda")
    hand = Group((FIRST,), None, members=("panda_hand_joint", FIRST, SECOND))
    groups = RobotGroups(replace(panda, groups={**panda.groups, "fingers": hand}), 0)
    assert groups.variables("fingers") == (FIRST, SECOND)
    assert groups.values_by_name("fingers", [0.01]) is None
    alone = Group((FIRST,), None, members=(FIRST,))
    groups_alone = RobotGroups(replace(panda, groups={**panda.groups, "fingers": alone}), 0)
    assert groups_alone.values_by_name("fingers", [0.01, 0.02]) is None
    assert groups.values_by_name("fingers", [0.01, 0.02]) == {FIRST: 0.01}


def test_active_joints_follow_no_other_one_and_all_joints_have_the_fixed_ones():
    groups = RobotGroups(load_robot("panda"), 0)
    assert groups.active_joints("hand") == (FIRST,)
    assert groups.active_joints("panda_arm")[-1] == "panda_joint7"
    assert groups.group_joints("panda_arm")[-1] == "panda_joint8"
