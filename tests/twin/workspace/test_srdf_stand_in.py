"""Where only the SRDF of a robot is there, a stand-in has its parts."""

from pathlib import Path

import pytest

from tracerisk.ros.robot.grippers import gripper_of
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.generic import NamesAsked
from tracerisk.twin.robots.names_in_source import Spoken
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.simulation.twin import Twin
from tracerisk.twin.urdf.srdf import read_srdf
from tracerisk.twin.workspace.srdf_stand_in import spoken_srdf, srdf_stand_in

SIDES = ("l", "r")


def arm(side: str) -> str:
    joints = "".join(f'<joint name="{side}_j{index}"/>' for index in range(1, 8))
    return f"""
      <group name="{side}_arm">{joints}<chain base_link="chest" tip_link="{side}_wrist"/></group>
      <group name="{side}_arm_waist"><joint name="waist"/>{joints}
        <chain base_link="stand" tip_link="{side}_wrist"/></group>
      <group name="{side}_hand">
        <link name="{side}_thumb"/><link name="{side}_palm"/>
        <joint name="{side}_grip"/><joint name="{side}_grip_too"/></group>
      <group_state name="rest" group="{side}_arm"><joint name="{side}_j2" value="0.5"/></group_state>
      <end_effector name="{side}_tool" parent_link="{side}_wrist" group="{side}_hand"/>
      <passive_joint name="{side}_grip_too"/>"""


TWO_ARMS = f"""<robot name="twins">{"".join(map(arm, SIDES))}
  <group name="both"><group name="l_arm"/><group name="r_arm"/></group></robot>"""


def stand_in(text: str, *joints: str) -> Robot:
    robot = srdf_stand_in(read_srdf(text, "twins.srdf"), NamesAsked(joints, ("eye_frame",)))
    assert robot is not None
    return robot


def test_two_arms_hang_on_one_waist_and_have_their_hands():
    robot = stand_in(TWO_ARMS)
    assert robot.name == "generic"
    assert robot.approximate
    hangs = {each.name: each for each in robot.attachments}
    assert hangs["waist"].parent == robot.base_link == "stand"
    assert {hangs[f"{side}_j1"].parent for side in SIDES} == {"chest"} == {hangs["waist"].child}
    assert robot.groups["l_arm"].joints == tuple(f"l_j{index}" for index in range(1, 8))
    assert robot.groups["l_arm"].tip_link == "l_wrist"
    assert robot.groups["both"].joints == (
        *robot.groups["l_arm"].joints, *robot.groups["r_arm"].joints
    )  # fmt: skip
    assert robot.named_states["r_arm"]["rest"] == {"r_j2": 0.5}
    assert [each.name for each in robot.grippers] == ["l_hand", "r_hand"]
    assert {"l_thumb", "r_palm", "eye_frame"} <= set(robot.link_names)


def test_joints_that_the_srdf_does_not_name_are_an_arm_beside():
    robot = stand_in(TWO_ARMS, "neck_yaw", "neck_pitch", "l_j1")
    hangs = {each.name: each for each in robot.attachments}
    assert hangs["neck_yaw"].parent == "stand"
    assert hangs["neck_pitch"].parent == hangs["neck_yaw"].child


def test_it_reaches_the_places_before_it():
    twin = Twin.build(stand_in(TWO_ARMS), load_scene("empty"))
    for side, y in (("l_arm", 0.2), ("r_arm", -0.2)):
        pose = Pose((0.3, y, 0.35), (-0.7071, 0.0, 0.0, 0.7071))
        found = twin.plan_pose(side, pose)
        assert found.joints == twin.robot.groups[side].joints


def test_a_group_of_which_only_states_name_the_joints():
    values = "".join(f'<joint name="axis_{letter}" value="0"/>' for letter in "abcdef")
    robot = stand_in(
        f"""<robot name="x"><group name="manipulator">
        <chain base_link="base" tip_link="flange"/></group>
        <group_state name="home" group="manipulator">{values}</group_state></robot>"""
    )
    assert len(robot.groups["manipulator"].joints) == 6
    assert robot.groups["manipulator"].tip_link == "flange"
    assert robot.base_link == "base"


def test_an_arm_that_is_declared_as_an_end_effector_stays_an_arm():
    values = "".join(f'<joint name="joint_a{n}" value="0"/>' for n in range(1, 7))
    robot = stand_in(
        f"""<robot name="x"><group name="end_effector">
        <chain base_link="base_link" tip_link="tool0"/></group>
        <group_state name="init" group="end_effector">{values}</group_state>
        <end_effector name="final" parent_link="base_link" group="end_effector"/></robot>"""
    )
    assert robot.groups["end_effector"].joints == tuple(f"joint_a{n}" for n in range(1, 7))
    assert robot.groups["end_effector"].tip_link == "tool0"
    assert not robot.grippers


def test_an_srdf_without_a_joint_gives_none():
    srdf = read_srdf('<robot name="x"><group name="arm"><link name="a"/></group></robot>', "x.srdf")
    assert srdf_stand_in(srdf, NamesAsked((), ())) is None


@pytest.mark.parametrize(("word", "file"), [("r_arm", "twins.srdf"), ("left_leg", "walker.srdf")])
def test_the_srdf_is_the_one_that_the_controller_names(tmp_path: Path, word: str, file: str):
    (tmp_path / "twins.srdf").write_text(TWO_ARMS)
    (tmp_path / "walker.srdf").write_text(
        '<robot name="walker"><group name="left_leg"><joint name="hip"/></group></robot>'
    )
    found = spoken_srdf((tmp_path,), Spoken((word,)), tmp_path / "c.py")
    assert found is not None
    assert found[1].name == file
    assert spoken_srdf((tmp_path,), Spoken(("gantry",)), tmp_path / "c.py") is None


@pytest.mark.parametrize(
    ("name", "hand"),
    [
        ("/left_hand_controller/gripper_cmd", "l_hand"),
        ("/cell/right_gripper/gripper_action", "r_hand"),
        ("/gripper_cmd", None),
        ("/left_to_right/gripper_cmd", None),
        ("/leftover/gripper_cmd", None),
    ],
)
def test_of_two_grippers_the_one_on_the_side_that_is_named(name: str, hand: str | None):
    found = gripper_of(stand_in(TWO_ARMS), name)
    assert (found.name if found else None) == hand
