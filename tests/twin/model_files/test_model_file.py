"""MJCF, URDF and xacro files become robots that stand and move as their makers' models do."""

import json
import math
import struct
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tracerisk.common.geometry.frames import rotation
from tracerisk.errors import RobotError
from tracerisk.twin.model_files import child, mjcf_model
from tracerisk.twin.model_files.bounds import bounding_shape
from tracerisk.twin.model_files.model_file import read_model_file
from tracerisk.twin.model_files.paths import ModelFolder
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.file import dump_robot, read_dumped_robot
from tracerisk.twin.robots.prefix import with_prefix
from tracerisk.twin.robots.robot_parts import Scaling
from tracerisk.twin.robots.sensors import Sensor
from tracerisk.twin.simulation.twin import Twin

ARM = """<mujoco model="reacher two">
  <compiler angle="radian" autolimits="true" meshdir="shapes"/>
  <default>
    <joint damping="1" armature="0.05"/>
    <default class="finger"><joint type="slide" axis="0 1 0" range="0 0.03"/></default>
  </default>
  <asset><mesh name="upper" file="upper.stl"/><texture name="t" type="2d" file="wood.png"/>
    <material name="wood" texture="t"/></asset>
  <worldbody>
    <light pos="0 0 3"/>
    <geom type="plane" size="1 1 .1"/>
    <body name="stand" pos="0.5 0 0.1">
      <geom type="cylinder" size="0.05 0.05" material="wood"/>
      <body name="upper_arm" pos="0 0 0.1" euler="0 0 0.3">
        <joint name="shoulder" axis="0 1 0" range="-2 2"/>
        <inertial pos="0 0 0.1" mass="2" diaginertia="0.02 0.02 0.01"/>
        <geom type="mesh" mesh="upper"/>
        <body name="fore_arm" pos="0 0 0.3">
          <joint name="elbow" pos="0 0 0.02" axis="0 1 0" range="-2 2.5" ref="0.4"/>
          <joint name="twist" axis="0 0 1"/>
          <inertial pos="0 0 0.1" mass="1" diaginertia="0.01 0.01 0.005"/>
          <geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.03"/>
          <body name="palm" pos="0 0 0.25">
            <joint name="reach" type="slide" axis="0 0 1" range="-0.05 0.05" ref="0.01"/>
            <inertial pos="0 0 0" mass="0.3" diaginertia="1e-3 1e-3 1e-3"/>
            <site name="tool_site" pos="0 0 0.05"/>
            <body name="left_finger" pos="0 0.01 0.03">
              <joint name="left" class="finger"/>
              <inertial pos="0 0 0" mass="0.02" diaginertia="1e-5 1e-5 1e-5"/>
              <geom type="box" size="0.01 0.005 0.02" pos="0 0 0.02"/>
              <geom type="box" size="0.002 0.002 0.002" pos="0 0 0.05"/>
            </body>
            <body name="right_finger" pos="0 -0.01 0.03" quat="0 0 0 1">
              <joint name="right" class="finger"/>
              <inertial pos="0 0 0" mass="0.02" diaginertia="1e-5 1e-5 1e-5"/>
              <geom type="box" size="0.01 0.005 0.02" pos="0 0 0.02"/>
            </body>
          </body>
        </body>
      </body>
    </body>
    <body name="cube" pos="0.3 0 0.05"><freejoint/><geom type="box" size=".02 .02 .02"/></body>
  </worldbody>
  <contact><exclude body1="stand" body2="fore_arm"/></contact>
  <tendon><fixed name="grip"><joint joint="left" coef="0.5"/><joint joint="right" coef="0.5"/></fixed></tendon>
  <actuator>
    <position name="m1" joint="shoulder" kp="900" kv="60" forcerange="-80 80"/>
    <position name="m2" joint="elbow" kp="100" kv="8" gear="2" forcerange="-20 20"/>
    <motor name="m3" joint="twist" gear="5" ctrlrange="-3 3"/>
    <position name="m5" tendon="grip" kp="200" forcerange="-40 40"/>
  </actuator>
  <keyframe><key name="home" qpos="0.5 1 0.2 0.02 0.01 0.01 0.3 0 0.05 1 0 0 0"/></keyframe>
</mujoco>
"""


IN_ITS_PROCESS = {
    "test_more_than_can_be_an_arm_is_refused_before_it_takes_memory",
    "test_a_mesh_that_mujoco_refuses_is_outlined",
}
"""Tests of what the process of the compiler does; the fixture `arm` is read with it too."""


@pytest.fixture(autouse=True)
def compiled_here(request, monkeypatch, tmp_path):
    """Let the compiler work in the process of the test, which need not start another."""
    if request.node.originalname in IN_ITS_PROCESS:
        return

    def answered(asked, *_):
        meshes = {name: Path(path).read_bytes() for name, path in asked["meshes"].items()}
        if asked["text"] is None:
            shapes = {each: child._shape_of(each, meshes[each], asked["scales"]) for each in meshes}
            return json.loads(json.dumps(shapes))
        try:
            return json.loads(json.dumps(child._model(asked["text"], meshes, asked["missing"])))
        except ValueError as error:
            return {"error": str(error)}

    # MuJoCo logs its warnings into a file of the working folder.
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(mjcf_model, "_asked", answered)


def read(folder, text=ARM, name="arm.xml", packages=None):
    path = folder / name
    path.write_text(text)
    return read_model_file(path, ModelFolder(folder, folder, packages or {}), shown=name)


def box_stl(*half):
    """A box as a binary STL."""
    corners = [np.array([x, y, z]) * half for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]  # fmt: skip
    rows = [
        struct.pack("<12fH", 0, 0, 0, *np.concatenate([corners[i] for i in f]), 0) for f in faces
    ]
    return bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows)


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    return read(tmp_path_factory.mktemp("arm")).robot


def test_joints_limits_and_motors_are_the_makers(arm):
    assert [joint.name for joint in arm.arm_joints] == ["shoulder", "elbow", "twist", "reach"]
    shoulder, elbow, twist = (arm.joint(name) for name in ("shoulder", "elbow", "twist"))
    assert (shoulder.lower, shoulder.upper, shoulder.torque_limit) == (-2.0, 2.0, 80.0)
    assert (shoulder.servo.stiffness, shoulder.servo.damping) == (900.0, 60.0)
    assert (shoulder.servo.armature, shoulder.servo.friction) == (0.05, 1.0)
    # A gear of two turns force into twice the torque, and stiffness into four times.
    assert (elbow.torque_limit, elbow.servo.stiffness, elbow.servo.damping) == (40.0, 400.0, 32.0)
    assert (twist.type, twist.torque_limit) == ("continuous", 15.0)
    assert arm.joint("reach").servo.stiffness > 0.0, "a joint without an actuator is given one"
    assert arm.approximate, "MJCF tells no rated velocities"
    assert arm.name == "reacher_two"


def test_actuators_keep_the_names_that_the_model_gives_them(arm):
    assert arm.actuators == {
        "m1": ("shoulder",),
        "m2": ("elbow",),
        "m3": ("twist",),
        "m5": ("left", "right"),
    }
    driven = {each.name: each.actuators for each in arm.elements if each.actuators}
    assert driven == {
        "shoulder": ("m1",),
        "elbow": ("m2",),
        "twist": ("m3",),
        "gripper": ("m5",),
    }


def test_an_actuator_without_a_name_is_none_of_the_named(tmp_path):
    robot = read(tmp_path, ARM.replace('<position name="m1"', "<position")).robot
    assert tuple(robot.actuators) == ("m2", "m3", "m5")
    assert {each.actuators for each in robot.elements if each.name == "shoulder"} == {()}


def test_a_prefix_stands_before_actuators_as_well(arm):
    assert with_prefix(arm, "left_").actuators["left_m5"] == ("left_left", "left_right")


def test_damping_beyond_a_drives_friction_is_the_servos(tmp_path):
    robot = read(tmp_path, ARM.replace('<joint damping="1"', '<joint damping="50"')).robot
    servo = robot.joint("shoulder").servo
    assert (servo.damping, servo.friction) == (60.0 + 49.0, 1.0)
    slow = read(tmp_path, ARM.replace('<joint damping="1"', '<joint damping="5000"')).robot
    assert slow.joint("shoulder").servo.stiffness != 900.0, "it would never arrive"


def test_frames_are_those_of_the_model_also_with_anchors_and_references(arm, tmp_path):
    own = ARM.replace('<geom type="mesh" mesh="upper"/>', "")
    own = own[: own.index("<asset>")] + own[own.index("<worldbody>") :].replace(
        'material="wood"', ""
    )
    theirs = mujoco.MjModel.from_xml_string(own)
    ours = compile_model(arm)
    here, there = mujoco.MjData(ours), mujoco.MjData(theirs)
    draw = np.random.default_rng(3)
    for _ in range(5):
        for joint in arm.joints:
            position = draw.uniform(joint.lower, joint.upper)
            here.qpos[ours.joint(joint.name).qposadr[0]] = position
            there.qpos[theirs.joint(joint.name).qposadr[0]] = position
        mujoco.mj_kinematics(ours, here)
        mujoco.mj_kinematics(theirs, there)
        base = there.body("stand").xpos
        for name in ("upper_arm", "fore_arm", "palm", "left_finger", "right_finger"):
            assert here.body(name).xpos == pytest.approx(there.body(name).xpos - base, abs=1e-9)
            assert here.body(name).xmat == pytest.approx(there.body(name).xmat, abs=1e-9)
        assert here.body("tool_site").xpos == pytest.approx(
            there.site("tool_site").xpos - base, abs=1e-9
        )


def test_masses_and_inertias_are_the_makers(arm):
    ours = compile_model(arm)
    assert float(ours.body("upper_arm").mass[0]) == pytest.approx(2.0)
    assert np.sort(ours.body("fore_arm").inertia) == pytest.approx([0.005, 0.01, 0.01])


def test_the_gripper_is_found_by_its_tendon_and_presses_with_its_larger_box(arm):
    (gripper,) = arm.grippers
    assert gripper.joints == ("left", "right")
    assert (gripper.opening, gripper.effort) == (0.03, 20.0)
    assert gripper.pads == ("left_finger", "right_finger")
    (link,) = [link for link in arm.links if link.name == "left_finger"]
    (pad,) = [shape for shape in link.shapes if shape.pad]
    assert pad.size == pytest.approx((0.01, 0.005, 0.02))


def test_keyframes_are_named_states_and_the_arm_begins_at_home(arm):
    home = {"shoulder": 0.5, "elbow": 1.0, "twist": 0.2, "reach": 0.02}
    assert dict(arm.named_states["arm"]["home"]) == pytest.approx(home)
    assert arm.initial_state["elbow"] == 1.0
    assert arm.groups["arm"].tip_link in ("palm", "tool_site")


def test_pairs_that_the_file_lets_touch_are_kept(arm):
    assert ("fore_arm", "stand") in arm.disabled_collisions


def test_what_stands_beside_the_arm_is_left_out(arm):
    assert "cube" not in arm.link_names
    assert arm.base_link == "stand"


def test_the_arm_survives_being_written_down(arm, tmp_path):
    path = tmp_path / "robot.json"
    path.write_text(dump_robot(arm))
    assert dump_robot(read_dumped_robot(path)) == dump_robot(arm)


def test_the_arm_stands_still_and_reaches_a_state(arm):
    twin = Twin.build(arm, load_scene("empty"))
    twin.advance(1_000_000_000)
    state = dict(zip(twin.joint_state().names, twin.joint_state().position, strict=True))
    assert state["shoulder"] == pytest.approx(0.5, abs=0.01)
    plan = twin.plan_joints(
        "arm",
        {"shoulder": 0.0, "elbow": 0.5, "twist": -0.4, "reach": 0.0},
        scaling=Scaling(0.5, 0.5),
    )
    motion = twin.follow(plan)
    while motion.outcome == "active":
        twin.advance(10**12)
    assert motion.outcome == "succeeded", motion.message


def test_a_force_that_the_file_measures_is_of_a_sensor_in_the_wrist(arm, tmp_path):
    assert arm.own_sensors == ()
    assert [sensor.part for sensor in arm.sensors] == ["shoulder", "elbow", "twist", "reach"]
    measured = ARM.replace(
        "</mujoco>",
        '<sensor><force site="tool_site"/><torque site="tool_site"/><jointpos joint="elbow"/>'
        "</sensor></mujoco>",
    )
    found = read(tmp_path, measured).robot
    assert found.own_sensors == (
        Sensor("wrench", "tool_site", "palm", topics=("tool_site", "wrench")),
    )
    twin = Twin.build(found, load_scene("empty"))
    twin.advance(2_000_000_000)
    force = twin.load_on("palm").force
    # Palm and fingers: 0.3 kg and twice 0.02 kg.
    assert math.hypot(*force) == pytest.approx(9.81 * 0.34, rel=0.01)


def test_two_arms_in_one_file_hang_on_one_root(tmp_path):
    one = ARM[ARM.index('<body name="stand"') : ARM.index('<body name="cube"')]
    other = one.replace('name="', 'name="b_').replace('pos="0.5 0 0.1"', 'pos="-0.5 0 0.1"')
    text = ARM.replace(one, one + other)
    text = text[: text.index("<keyframe>")] + "</mujoco>"
    text = text.replace(
        '<position name="m1"',
        '<position name="b1" joint="b_shoulder" kp="900"/><position name="m1"',
    )
    robot = read(tmp_path, text).robot
    assert robot.base_link == "world_link"
    assert {"shoulder", "b_shoulder"} <= {joint.name for joint in robot.arm_joints}
    assert {"arm", "arm_2"} <= robot.groups.keys()


def test_a_follower_outside_a_gripper_and_a_closed_loop_stand_still(tmp_path):
    text = ARM.replace(
        "<contact>",
        '<equality><joint joint1="reach" joint2="elbow"/>'
        '<connect body1="fore_arm" body2="stand" anchor="0 0 0"/></equality><contact>',
    ).replace('<motor name="m3" joint="twist" gear="5" ctrlrange="-3 3"/>', "")
    robot = read(tmp_path, text).robot
    assert [joint.name for joint in robot.arm_joints] == ["shoulder", "elbow"]


def test_a_mesh_that_is_there_is_bounded_and_one_that_is_not_is_outlined(arm, tmp_path):
    (outlined,) = [link.shapes for link in arm.links if link.name == "upper_arm"]
    assert [shape.kind for shape in outlined] == ["capsule"]
    (tmp_path / "shapes").mkdir()
    (tmp_path / "shapes" / "upper.stl").write_bytes(box_stl(0.02, 0.03, 0.15))
    read_file = read(tmp_path)
    assert (tmp_path / "shapes" / "upper.stl").resolve() in read_file.files
    (bounded,) = [link.shapes for link in read_file.robot.links if link.name == "upper_arm"]
    assert [shape.kind for shape in bounded] == ["box"]
    assert sorted(bounded[0].size) == pytest.approx([0.02, 0.03, 0.15], abs=1e-6)


def test_a_mesh_that_mujoco_refuses_is_outlined(tmp_path):
    (tmp_path / "shapes").mkdir()
    (tmp_path / "shapes" / "upper.stl").write_bytes(b"solid nothing\nendsolid nothing\n")
    (link,) = [link for link in read(tmp_path).robot.links if link.name == "upper_arm"]
    assert [shape.kind for shape in link.shapes] == ["capsule"]


@pytest.mark.parametrize("seed", range(6))
def test_a_bounding_shape_holds_every_vertex(seed):
    draw = np.random.default_rng(seed)
    points = (
        draw.normal(size=(200, 3))
        * draw.uniform(0.01, 1.0, 3)
        @ rotation(tuple(draw.uniform(-3, 3, 3)))
    )
    if seed == 0:
        points[:, 2] = 0.0
    shape = bounding_shape(points)
    x, y, z = ((points - np.array(shape.xyz)) @ rotation(shape.rpy)).T
    if shape.kind == "box":
        outside = np.maximum.reduce(
            [np.abs(c) - s for c, s in zip((x, y, z), shape.size, strict=True)]
        )
    elif shape.kind == "sphere":
        outside = np.sqrt(x * x + y * y + z * z) - shape.size[0]
    elif shape.kind == "cylinder":
        outside = np.maximum(np.hypot(x, y) - shape.size[0], np.abs(z) - shape.size[1])
    else:
        past = np.maximum(np.abs(z) - shape.size[1], 0.0)
        outside = np.sqrt(x * x + y * y + past * past) - shape.size[0]
    assert outside.max() < 1e-9


def test_includes_are_put_in_place(tmp_path):
    motors = ARM[ARM.index("  <actuator>") : ARM.index("  <keyframe>")]
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "motors.xml").write_text(f"<mujocoinclude>{motors}</mujocoinclude>")
    found = read(tmp_path, ARM.replace(motors, '<include file="parts/motors.xml"/>'))
    assert found.robot.joint("shoulder").torque_limit == 80.0
    assert (tmp_path / "parts" / "motors.xml").resolve() in found.files


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('<include file="../other.xml"/>', r"arm.xml:2: <include>: '\.\./other.xml' lies outside"),
        ('<include file="/etc/hostname"/>', r"arm.xml:2: <include>: '/etc/hostname' lies outside"),
        ('<include file="gone.xml"/>', r"arm.xml:2: <include>: there is no file 'gone.xml'"),
        ('<include file="arm.xml"/>', r"arm.xml:2: <include>: 'arm.xml' is included twice"),
        ('<asset><mesh file="../a.stl"/></asset>', r"arm.xml:2: <mesh>: '\.\./a.stl' lies outside"),
        ('<asset><texture type="2d" name="t" file="/etc/passwd"/></asset>', "arm.xml:2: <texture>: .* outside"),
        ('<asset><hfield name="h" nrow="90000" ncol="90000" size="1 1 1 1"/></asset>', "arm.xml:2: <hfield>: attribute 'nrow' is 90000; at most"),
        ('<asset><model name="m" file="x.xml"/></asset>', "arm.xml:2: <model>: is not read"),
        ('<extension><plugin plugin="mujoco.elasticity.cable"/></extension>', "arm.xml:2: <extension>: is not read: code of others"),
        ('<worldbody><composite type="cable" count="1000000 1 1"/></worldbody>', "arm.xml:2: <composite>: is not read: soft"),
        ('<worldbody><flexcomp name="f" type="grid" count="999 999 9"/></worldbody>', "arm.xml:2: <flexcomp>: is not read: soft"),
        ('<worldbody><replicate count="100000000"><body/></replicate></worldbody>', "arm.xml:2: <replicate>: makes 100000000 copies"),
        ('<worldbody><replicate count="999"><replicate count="999"><body/></replicate></replicate></worldbody>', "arm.xml:2: <replicate>: makes 998001 copies"),
        ('<worldbody><body pos="0 nan 0"/></worldbody>', "arm.xml:2: <body>: attribute 'pos' is '0 nan 0'"),
        ('<worldbody><body wobble="1"/></worldbody>', "arm.xml:2: MuJoCo refuses the model: .*wobble"),
        ("<worldbody/>", "arm.xml: has no joint that moves an arm"),
    ],
)  # fmt: skip
def test_what_is_not_read_is_reported_with_its_line(tmp_path, text, message):
    with pytest.raises(RobotError, match=message):
        read(tmp_path, f"<mujoco>\n{text}</mujoco>")


def test_a_link_of_the_file_system_leads_nowhere_else(tmp_path):
    folder = tmp_path / "model"
    folder.mkdir()
    (tmp_path / "secret.xml").write_text("<mujocoinclude/>")
    (folder / "inner.xml").symlink_to(tmp_path / "secret.xml")
    with pytest.raises(RobotError, match=r"'inner.xml' lies outside"):
        read(folder, '<mujoco><include file="inner.xml"/></mujoco>')


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('mass="2"', 'mass="2e7"'), "link 'upper_arm' weighs 2e\\+07 kg"),
        (('pos="0 0 0.3"', 'pos="0 0 300"'), "joint 'elbow' is 300.02 m away .* millimetres"),
        (('size="0.03"', 'size="300"'), "link 'fore_arm' is 300 m large"),
    ],
)
def test_absurd_sizes_are_reported(tmp_path, change, message):
    with pytest.raises(RobotError, match=message):
        read(tmp_path, ARM.replace(*change))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a" * 5000, "<mesh>: 'aaa.* names no file: .*too long"),
        ("http://[half/a.stl", r"<mesh>: 'http://\[half/a.stl' names no file"),
        ("package://own/%00", "<mesh>: .* names no file: .*null"),
        ("loop.stl", "<mesh>: 'loop.stl' names no file: .*oop"),
    ],
)
def test_names_that_no_file_can_have_are_reported(tmp_path, name, message):
    (tmp_path / "loop.stl").symlink_to(tmp_path / "loop.stl")
    text = f'<mujoco><asset><mesh name="m" file="{name}"/></asset></mujoco>'
    with pytest.raises(RobotError, match=message):
        read(tmp_path, text, packages={"own": tmp_path})


def test_more_than_can_be_an_arm_is_refused_before_it_takes_memory(tmp_path):
    with pytest.raises(RobotError, match="at most 200000 elements are read"):
        read(tmp_path, f"<mujoco>{'<a/>' * 300_000}</mujoco>")
    chain = "".join(
        f'<link name="l{i}"/><joint name="j{i}" type="fixed"><parent link="l{i}"/>'
        f'<child link="l{i + 1}"/></joint>'
        for i in range(3000)
    )
    with pytest.raises(RobotError, match="at most 500 links are simulated"):
        read(tmp_path, f'<robot name="r">{chain}<link name="l3000"/></robot>', "chain.urdf")


def test_a_macro_that_grows_without_bounds_is_refused(tmp_path):
    text = '<robot name="r" xmlns:xacro="x">${"b" * 17000000}</robot>'
    with pytest.raises(RobotError, match=r"it expands to 17\d* characters; at most 16777216"):
        read(tmp_path, text, "macro.xacro")


def test_an_encoding_that_python_lacks_is_reported(tmp_path):
    with pytest.raises(RobotError, match=r"arm.xml:1: is not XML that can be read: .*klingon"):
        read(tmp_path, '<?xml version="1.0" encoding="klingon"?><mujoco/>')


def test_a_link_that_reaches_into_the_floor_is_not_held_by_it(tmp_path):
    text = """<mujoco><worldbody><body name="stand">
      <body name="turret"><joint name="pan" axis="0 0 1" range="-150 150"/>
        <geom type="box" size="0.04 0.04 0.05" pos="0 0 0.045" mass="1"/></body>
    </body></worldbody>
    <actuator><position joint="pan" kp="50" kv="5" forcerange="-5 5"/></actuator></mujoco>"""
    robot = read(tmp_path, text).robot
    twin = Twin.build(robot, load_scene("empty"))
    motion = twin.follow(twin.plan_joints("arm", {"pan": 0.5}, scaling=Scaling(1.0, 0.1)))
    while motion.outcome == "active":
        twin.advance(10**12)
    assert motion.outcome == "succeeded", motion.message
