"""URDF and SRDF texts become robots that stand and move."""

import math

import pytest

from tracerisk.errors import RobotError
from tracerisk.ros.moveit.robot_groups import RobotGroups
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.motion import PlanningError, Pose
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.file import dump_robot, read_dumped_robot
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin
from tracerisk.twin.urdf.assembly import ASSUMED_VELOCITY
from tracerisk.twin.urdf.srdf import read_srdf
from tracerisk.twin.urdf.text import urdf_text
from tracerisk.twin.urdf.urdf import read_urdf

URDF = """<?xml version="1.0"?>
<robot name="tiny">
  <link name="world"/>
  <link name="base"><visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
  <joint name="stand" type="fixed"><parent link="world"/><child link="base"/></joint>
  <link name="wheel_left"/>
  <joint name="wheel_left_joint" type="continuous">
    <parent link="base"/><child link="wheel_left"/><axis xyz="0 1 0"/>
  </joint>
  <link name="upper">
    <inertial><origin xyz="0 0 0.1" rpy="0 0 1.5707963"/><mass value="2"/>
      <inertia ixx="0.02" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://nowhere/upper.stl"/></geometry></visual>
  </link>
  <joint name="shoulder" type="revolute">
    <origin xyz="0 0 0.1"/><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="40" velocity="1.5"/>
  </joint>
  <link name="fore"><inertial><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="elbow" type="revolute">
    <origin xyz="0 0 0.3"/><parent link="upper"/><child link="fore"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" {elbow}/>
  </joint>
  <link name="tool"/>
  <joint name="tool_joint" type="fixed">
    <origin xyz="0 0 0.2"/><parent link="fore"/><child link="tool"/></joint>
  <link name="left_finger"><inertial><mass value="0.02"/>
    <inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="left_finger_joint" type="prismatic">
    <parent link="tool"/><child link="left_finger"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.03" effort="15" velocity="0.1"/>
  </joint>
  <link name="right_finger"><inertial><mass value="0.02"/>
    <inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="right_finger_joint" type="prismatic">
    <parent link="tool"/><child link="right_finger"/><axis xyz="0 1 0"/>
    <limit lower="-0.03" upper="0" effort="15" velocity="0.1"/>
    <mimic joint="left_finger_joint" multiplier="-1"/>
  </joint>
</robot>
"""
RATED = URDF.replace("{elbow}", 'effort="20" velocity="2"')

SRDF = """<robot name="tiny">
  <group name="limb"><chain base_link="base" tip_link="tool"/></group>
  <group name="claw"><joint name="left_finger_joint"/><joint name="right_finger_joint"/></group>
  <group name="all"><group name="limb"/><group name="claw"/></group>
  <group_state name="ready" group="limb">
    <joint name="shoulder" value="0.4"/><joint name="elbow" value="9"/></group_state>
  <group_state name="wide" group="claw"><joint name="left_finger_joint" value="0.03"/></group_state>
  <end_effector name="hand" parent_link="tool" group="claw"/>
  <disable_collisions link1="upper" link2="base" reason="Adjacent"/>
</robot>
"""


def robot(text=RATED):
    return read_urdf(text, "tiny.urdf", srdf=read_srdf(SRDF, "tiny.srdf"))


def test_what_steers_a_wheel_is_no_joint_of_the_arm():
    steered = robot(RATED.replace("wheel_left", "steer_left").replace("continuous", "revolute"))
    assert [joint.name for joint in steered.arm_joints] == ["shoulder", "elbow"]


def test_the_arm_is_read_and_can_be_simulated():
    tiny = robot()
    assert tiny.base_link == "base", "a frame below the base is left out"
    assert [joint.name for joint in tiny.arm_joints] == ["shoulder", "elbow"], "wheels stand still"
    assert tiny.joint("shoulder").torque_limit == 40.0
    assert tiny.joint("shoulder").velocity_limit == 1.5
    assert not tiny.approximate
    model = compile_model(tiny)
    assert model.njnt == 4


LEVEL = {"shoulder": math.pi / 2, "elbow": 0.0}
RAISED = RATED.replace(
    '<child link="base"/></joint>',
    '<child link="base"/><origin xyz="0.3 0 0.8" rpy="0 0 1.5707963"/></joint>',
)


def test_the_origin_of_the_fixed_world_joint_places_the_arm():
    assert RAISED != RATED
    raised = robot(RAISED)
    assert raised.base_link == "world_link"
    base = Kinematics(raised).forward({}, "base")
    assert base.position == pytest.approx((0.3, 0.0, 0.8))
    tool = Kinematics(raised).forward(LEVEL, "tool")
    assert tool.position == pytest.approx((0.3, 0.5, 0.9), abs=1e-6), "x of the base is y here"


def test_a_pose_in_the_frame_of_the_world_is_planned_to_on_a_stand():
    goal = Pose((0.3, 0.5, 0.9), Kinematics(robot(RAISED)).forward(LEVEL, "tool").orientation)
    planned = Twin.build(robot(RAISED), load_scene("empty")).plan_pose("limb", goal)
    assert planned.position[-1] == pytest.approx([math.pi / 2, 0.0], abs=1e-3)
    with pytest.raises(PlanningError):
        Twin.build(robot(), load_scene("empty")).plan_pose("limb", goal)


@pytest.mark.parametrize("text", [RATED, RAISED], ids=["at the origin", "raised"])
def test_a_chain_of_the_srdf_may_begin_at_the_world(text: str):
    srdf = SRDF.replace(
        '<chain base_link="base" tip_link="tool"/>', '<chain base_link="world" tip_link="tool"/>'
    )
    tiny = read_urdf(text, "tiny.urdf", srdf=read_srdf(srdf, "tiny.srdf"))
    assert tiny.groups["limb"].joints == ("shoulder", "elbow")


def test_inertias_are_turned_into_the_axes_of_the_link():
    upper = next(link for link in robot().links if link.name == "upper")
    assert upper.inertia == pytest.approx((0.01, 0.02, 0.01, 0.0, 0.0, 0.0), abs=1e-6)
    assert upper.centre_of_mass == (0.0, 0.0, 0.1)


def test_an_inertia_that_is_far_too_large_for_its_mass_is_a_placeholder():
    plain = '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
    assert plain in RATED
    large = RATED.replace(plain, plain.replace("0.01", "1.5"))
    fore = next(link for link in robot(large).links if link.name == "fore")
    assert (fore.mass, fore.inertia) == (1.0, None)


def test_a_mesh_is_drawn_as_a_capsule_to_the_next_joint():
    upper = next(link for link in robot().links if link.name == "upper")
    assert [shape.kind for shape in upper.shapes] == ["capsule"]
    assert upper.shapes[0].size[1] == pytest.approx(0.15)


def test_groups_states_and_collisions_are_those_of_the_srdf():
    tiny = robot()
    assert tiny.groups["limb"].joints == ("shoulder", "elbow")
    assert tiny.groups["limb"].tip_link == "tool"
    assert set(tiny.groups["all"].joints) >= {"shoulder", "elbow", "left_finger_joint"}
    assert dict(tiny.named_states["limb"]["ready"]) == {"shoulder": 0.4, "elbow": 2.0}, "in limits"
    assert tiny.disabled_collisions == {("base", "upper")}


def test_the_members_of_a_group_are_in_the_order_of_moveit_whatever_order_the_file_has():
    # MoveIt goes into the depth, and from joint to joint of a link by their names.
    text = """<robot name="claw"><link name="palm"/><link name="a"/><link name="b"/><link name="t"/>
    <joint name="master" type="revolute"><parent link="palm"/><child link="a"/><axis xyz="0 0 1"/>
      <limit lower="0" upper="0.8" effort="9" velocity="1"/></joint>
    <joint name="knuckle" type="revolute"><parent link="palm"/><child link="b"/>
      <axis xyz="0 0 1"/><mimic joint="master"/>
      <limit lower="0" upper="0.8" effort="9" velocity="1"/></joint>
    <joint name="tip" type="revolute"><parent link="b"/><child link="t"/>
      <axis xyz="0 0 1"/><mimic joint="master" multiplier="-1"/>
      <limit lower="-0.8" upper="0" effort="9" velocity="1"/></joint></robot>"""
    srdf = """<robot name="claw"><group name="hand">
      <joint name="master"/><joint name="tip"/><joint name="knuckle"/></group></robot>"""
    found = read_urdf(text, "claw.urdf", srdf=read_srdf(srdf, "claw.srdf"))
    assert found.groups["hand"].members == ("knuckle", "tip", "master")
    assert found.groups["hand"].joints == ("master",)


def test_fingers_make_a_gripper_that_moves_as_its_first_joint():
    (gripper,) = robot().grippers
    assert gripper.group == "claw"
    assert gripper.joints == ("left_finger_joint", "right_finger_joint")
    assert gripper.signs == (1, -1)
    assert gripper.opening == 0.03
    assert gripper.effort == 15.0
    assert set(gripper.pads) == {"left_finger", "right_finger"}


def test_a_finger_that_no_group_plans_for_follows_the_first_in_the_robots_text():
    follows = '<mimic joint="left_finger_joint" multiplier="-1" offset="0" />'
    assert urdf_text(robot()).count("<mimic") == urdf_text(robot()).count(follows) == 1
    assert "<mimic" not in urdf_text(load_robot("panda"))


def linked(name: str, parent: str, mimics: str = "") -> str:
    mimic = f'<mimic joint="{mimics}"/>' if mimics else ""
    return f"""<link name="{name}_bar"><inertial><mass value="0.02"/>
      <inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="{name}" type="revolute"><origin xyz="0 0 0.03"/><parent link="{parent}"/>
      <child link="{name}_bar"/><axis xyz="1 0 0"/>
      <limit lower="0" upper="1.1" effort="5" velocity="1"/>{mimic}</joint>"""


def with_links(*joints: str) -> str:
    head, _, _ = RATED.partition('  <link name="left_finger">')
    return head + "".join(joints) + "</robot>"


def test_fingers_of_two_links_that_mimic_one_joint_are_one_gripper():
    text = with_links(
        linked("r1", "tool"),
        linked("r2", "r1_bar", "r1"),
        linked("l1", "tool", "r1"),
        linked("l2", "l1_bar", "r1"),
    )
    found = read_urdf(text, "tiny.urdf")
    assert [joint.name for joint in found.arm_joints] == ["shoulder", "elbow"]
    (gripper,) = found.grippers
    assert gripper.joints == ("r1", "r2", "l1", "l2")
    assert set(gripper.pads) == {"r2_bar", "l2_bar"}


def test_a_joint_that_levels_the_tool_makes_its_leader_no_finger():
    text = with_links(linked("lift", "tool"), linked("level", "lift_bar", "lift"))
    found = read_urdf(text, "tiny.urdf")
    assert "lift" in [joint.name for joint in found.arm_joints]


def test_a_joint_that_carries_two_fingers_turns_the_hand_and_is_none():
    text = with_links(
        linked("turn", "tool").replace("turn_bar", "clawbase"),
        linked("clawr", "clawbase"),
        linked("clawl", "clawbase", "clawr"),
    )
    found = read_urdf(text, "tiny.urdf")
    assert [joint.name for joint in found.arm_joints] == ["shoulder", "elbow", "turn"]
    assert found.grippers[0].joints == ("clawr", "clawl")


@pytest.mark.parametrize(
    "claw",
    [
        '<joint name="left_finger_joint"/><joint name="right_finger_joint"/>',
        '<link name="left_finger"/><link name="tcp"/><link name="right_finger"/>',
        '<chain base_link="tool" tip_link="left_finger"/><link name="right_finger"/>',
    ],
    ids=["joints", "links", "a chain and a link"],
)
def test_fingers_of_an_end_effector_follow_each_other_though_one_carries_the_tool(claw):
    tcp = (
        '<link name="tcp"/><joint name="end" type="fixed"><parent link="left_finger"/>'
        '<child link="tcp"/></joint></robot>'
    )
    text = RATED.replace("</robot>", tcp)
    listed = '<joint name="left_finger_joint"/><joint name="right_finger_joint"/>'
    srdf = SRDF.replace(listed, claw)
    for side in ("left", "right"):
        # Nothing but the SRDF says that these are fingers.
        text, srdf = (t.replace(f"{side}_finger", f"{side}_part") for t in (text, srdf))
    found = read_urdf(text, "tiny.urdf", srdf=read_srdf(srdf, "tiny.srdf"))
    assert [one.joints for one in found.grippers] == [("left_part_joint", "right_part_joint")]
    assert RobotGroups(found, 0).variables("claw") == ("left_part_joint", "right_part_joint")


def test_the_last_joint_of_an_arm_is_no_gripper_though_the_end_effectors_group_has_it():
    head, _, _ = RATED.partition('  <link name="left_finger">')
    srdf = """<robot name="tiny">
      <group name="limb"><chain base_link="base" tip_link="fore"/></group>
      <group name="flange"><link name="fore"/><joint name="elbow"/></group>
      <end_effector name="eef" parent_link="fore" group="flange" parent_group="limb"/></robot>"""
    found = read_urdf(head + "</robot>", "tiny.urdf", srdf=read_srdf(srdf, "tiny.srdf"))
    assert [joint.name for joint in found.arm_joints] == ["shoulder", "elbow"]
    assert not found.grippers


def test_figures_that_are_missing_are_assumed_and_the_robot_says_so():
    tiny = robot(URDF.replace("{elbow}", ""))
    assert tiny.approximate
    elbow = tiny.joint("elbow")
    assert elbow.velocity_limit == ASSUMED_VELOCITY["revolute"]
    assert elbow.torque_limit >= 1.0


def test_a_motor_too_weak_to_lift_its_arm_is_a_placeholder():
    tiny = robot(URDF.replace("{elbow}", 'effort="20" velocity="2"').replace('"40"', '"0.1"'))
    assert tiny.approximate
    assert tiny.joint("shoulder").torque_limit > 2 * 9.81 * 0.1 + 9.81 * 0.3


def test_without_an_srdf_the_arm_and_the_gripper_are_groups():
    tiny = read_urdf(RATED, "tiny.urdf")
    assert tiny.groups["arm"].joints == ("shoulder", "elbow")
    assert tiny.groups["arm"].tip_link == "tool"
    assert tiny.groups["gripper"].joints[0] == "left_finger_joint"


def test_a_robot_survives_the_way_through_a_file(tmp_path):
    path = tmp_path / "robot.json"
    path.write_text(dump_robot(robot()), encoding="utf-8")
    assert read_dumped_robot(path) == robot()


def test_endless_joints_turn_at_will():
    text = RATED.replace('name="elbow" type="revolute"', 'name="elbow" type="continuous"')
    elbow = robot(text).joint("elbow")
    assert (elbow.lower, elbow.upper) == (-2 * math.pi, 2 * math.pi)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot><link", r"bad.urdf:1:\d+: is not XML"),
        ('<!DOCTYPE x [<!ENTITY a "b">]><robot/>', "bad.urdf:1: declares a document type"),
        ("<robot/>", "has no link"),
        ("<robot>" + "<a>" * 300 + "</a>" * 300 + "</robot>", "deeper than 200"),
        ('<robot><link name="a"/><link name="b"/></robot>', "2 links have no parent"),
        ('<robot><link name="a"/></robot>', "no joint that moves"),
        (RATED.replace('link="fore"/>', 'link="for"/>', 1), "no link 'for'; did you mean 'fore'"),
        (RATED.replace('type="prismatic"', 'type="slides"'), "unknown joint type 'slides'"),
        (RATED.replace('lower="-2"', 'lower="low"'), "attribute 'lower' is 'low'; give a number"),
        ("<sdf/>", "is not the element <robot>"),
    ],
)
def test_what_is_no_robot_is_reported_with_its_place(text, message):
    with pytest.raises(RobotError, match=message):
        read_urdf(text, "bad.urdf")


def test_a_passive_joint_that_carries_only_a_frame_stands_still_and_is_no_finger():
    added = """<link name="gripper_frame"/>
  <joint name="gripper_frame_joint" type="revolute">
    <origin xyz="0 0 0.1"/><parent link="fore"/><child link="gripper_frame"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" effort="30" velocity="1"/>
  </joint>
</robot>"""
    text = RATED.replace("</robot>", added)
    passive = SRDF.replace("</robot>", '<passive_joint name="gripper_frame_joint"/></robot>')
    passive = passive.replace('tip_link="tool"', 'tip_link="gripper_frame"')
    tiny = read_urdf(text, "tiny.urdf", srdf=read_srdf(passive, "tiny.srdf"))
    assert "gripper_frame_joint" not in [joint.name for joint in tiny.joints]
    assert [gripper.joints for gripper in tiny.grippers] == [
        ("left_finger_joint", "right_finger_joint")
    ]
    (frame,) = (link for link in tiny.links if link.name == "gripper_frame")
    assert not frame.shapes
    assert tiny.group("limb").tip_link == "gripper_frame"


def parallelogram(*joints: str) -> str:
    """An arm whose third joint, `reach`, others follow."""
    bend = linked("lift", "tool")
    return with_links(bend, linked("reach", "lift_bar"), *joints)


@pytest.mark.parametrize(
    "rods",
    [
        (linked("rod", "tool", "reach"), linked("level", "reach_bar", "reach")),
        (linked("rod", "lift_bar", "reach"), linked("level", "reach_bar", "reach")),
        (linked("rod", "tool", "lift"), linked("second", "rod_bar", "lift")),
        (
            linked("rod", "lift_bar", "reach"),
            '<link name="tcp"/><joint name="end" type="fixed"><parent link="reach_bar"/>'
            '<child link="tcp"/></joint>',
        ),
    ],
    ids=[
        "rod at the joint before",
        "rod beside it",
        "rods of the joint before",
        "carries the tool",
    ],
)
def test_an_arm_joint_that_rods_of_a_parallelogram_follow_is_no_gripper(rods):
    found = read_urdf(parallelogram(*rods), "tiny.urdf")
    assert [joint.name for joint in found.arm_joints] == ["shoulder", "elbow", "lift", "reach"]
    assert found.grippers == ()
    assert "stand still on the twin" in found.assumed_figures[0]


@pytest.mark.parametrize(
    ("srdf", "begins"),
    [
        (None, {"left_finger_joint": 0.03, "right_finger_joint": -0.03}),
        (SRDF, {"left_finger_joint": 0.03, "right_finger_joint": -0.03}),
        (
            SRDF.replace('name="wide"', 'name="home"').replace("0.03", "0.01"),
            {"left_finger_joint": 0.01},
        ),
    ],
    ids=["no SRDF", "no state at rest", "closed at rest"],
)
def test_a_gripper_begins_open_unless_its_files_say_where(srdf, begins):
    given = None if srdf is None else read_srdf(srdf, "tiny.srdf")
    found = read_urdf(RATED, "tiny.urdf", srdf=given)
    assert {name: found.initial_state[name] for name in begins} == begins


def test_a_gripper_begins_where_its_hardware_does():
    hardware = (
        '<ros2_control name="h" type="system"><joint name="left_finger_joint"><state_interface '
        'name="position"><param name="initial_value">0.0</param></state_interface></joint>'
        "</ros2_control></robot>"
    )
    found = read_urdf(RATED.replace("</robot>", hardware), "tiny.urdf")
    assert found.initial_state["left_finger_joint"] == 0.0


@pytest.mark.parametrize(
    "group",
    [
        '<chain base_link="base" tip_link="tool"/>',
        '<link name="base"/><joint name="shoulder"/><joint name="elbow"/>',
        '<link name="base"/><link name="upper"/><link name="fore"/>',
    ],
    ids=["a chain", "a link and joints", "links"],
)
def test_an_arm_that_its_srdf_calls_an_end_effector_stays_an_arm(group: str):
    head, _, _ = RATED.partition('  <link name="left_finger">')
    srdf = f"""<robot name="tiny"><group name="limb">{group}</group>
      <end_effector name="flange" parent_link="base" group="limb"/></robot>"""
    found = read_urdf(head + "</robot>", "tiny.urdf", srdf=read_srdf(srdf, "tiny.srdf"))
    assert [joint.name for joint in found.arm_joints] == ["shoulder", "elbow"]
    assert not found.grippers
