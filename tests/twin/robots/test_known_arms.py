"""Descriptions of arms that are shipped too, under other names or with placeholders for limits."""

import re

import numpy as np
import pytest

from tracerisk.twin.model_files.model_file import read_model_file
from tracerisk.twin.model_files.paths import ModelFolder
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.robots.index import shipped_names
from tracerisk.twin.robots.robot import Robot, load_robot

import mujoco  # isort: skip

# The bodies and ranges of the Panda as public models of it have them, whose joints are `joint1`...
RANGES = ("-2.8973 2.8973", "-1.7628 1.7628", "-2.8973 2.8973", "-3.0718 -0.0698",
          "-2.8973 2.8973", "-0.0175 3.7525", "-2.8973 2.8973")  # fmt: skip
FRAMES = ('pos="0 0 0.333"', 'quat="1 -1 0 0"', 'pos="0 -0.316 0" quat="1 1 0 0"',
          'pos="0.0825 0 0" quat="1 1 0 0"', 'pos="-0.0825 0.384 0" quat="1 -1 0 0"',
          'quat="1 1 0 0"', 'pos="0.088 0 0" quat="1 1 0 0"')  # fmt: skip


def mjcf(frames=FRAMES, ranges=RANGES):
    bodies = "".join(
        f'<body name="link{n}" {frame}><inertial pos="0 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>'
        f'<joint name="joint{n}" axis="0 0 1" range="{limits}"/>'
        for n, (frame, limits) in enumerate(zip(frames, ranges, strict=True), 1)
    )
    motors = "".join(
        f'<position name="motor{n}" joint="joint{n}" kp="2000" kv="200" forcerange="-87 87"/>'
        for n in range(1, len(frames) + 1)
    )
    return (
        '<mujoco model="arm"><compiler angle="radian"/><worldbody><body name="link0">'
        + bodies + "</body>" * (len(frames) + 1)
        + f"</worldbody><actuator>{motors}</actuator></mujoco>"
    )  # fmt: skip


def urdf(robot, *, velocity=None, effort=None, reach=None, mass=None):
    """Return the URDF of a shipped robot's arm, with the same figures for each part where given."""
    parts = [
        f'<link name="{link.name}"><inertial><mass value="{mass or max(link.mass, 0.01)}"/><inertia '
        'ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for link in robot.links
    ]
    for at in robot.attachments:
        xyz, rpy, axis = (" ".join(map(str, each)) for each in (at.xyz, at.rpy, at.axis))
        limit = ""
        if at.type != "fixed":
            joint = robot.joint(at.name)
            lower, upper = (joint.lower, joint.upper) if reach is None else (-reach, reach)
            limit = (
                f'<limit lower="{lower}" upper="{upper}" '
                f'velocity="{velocity or joint.velocity_limit}" '
                f'effort="{effort or joint.torque_limit}"/>'
            )
        parts.append(
            f'<joint name="{at.name}" type="{at.type}"><parent link="{at.parent}"/>'
            f'<child link="{at.child}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
            f"{limit}</joint>"
        )
    return f'<robot name="cell_arm">{"".join(parts)}</robot>'


@pytest.fixture
def read(tmp_path):
    def robot_of(text):
        suffix = "xml" if text.startswith("<mujoco") else "urdf"
        file = tmp_path / f"arm.{suffix}"
        file.write_text(text)
        return read_model_file(file, ModelFolder(tmp_path, tmp_path, {})).robot

    return robot_of


def test_an_arm_whose_joints_are_called_otherwise_takes_the_limits_of_the_shipped_one(read):
    robot, panda = read(mjcf()), load_robot("panda")
    for mine, ours in zip(robot.arm_joints, panda.arm_joints, strict=True):
        assert mine.velocity_limit == ours.velocity_limit
        assert mine.acceleration_limit == ours.acceleration_limit
        assert mine.torque_limit == 87.0
    (sentence,) = robot.assumed_figures
    assert "those of the shipped robot 'panda'" in sentence


@pytest.mark.parametrize(
    "changed",
    [
        mjcf((*FRAMES[:2], 'pos="0 -0.4 0" quat="1 1 0 0"', *FRAMES[3:])),
        mjcf(ranges=("-1 1", *RANGES[1:])),
        mjcf(FRAMES[:6], RANGES[:6]),
    ],
    ids=["another length", "another range", "a joint less"],
)
def test_an_arm_of_another_shape_does_not(read, changed):
    robot = read(changed)
    assert robot.assumed_figures == ()
    assert robot.arm_joints[0].velocity_limit != load_robot("panda").arm_joints[0].velocity_limit


@pytest.mark.parametrize("name", ["m1013", "panda", "gen3"])
def test_limits_that_are_placeholders_are_those_of_the_shipped_robot(read, name):
    ours = load_robot(name)
    robot = read(urdf(ours, velocity=1.571, effort=1000.0, reach=2.617))
    for joint in ours.arm_joints:
        mine = robot.joint(joint.name)
        if mine.type == joint.type:
            assert (mine.lower, mine.upper) == (joint.lower, joint.upper)
            assert mine.velocity_limit == joint.velocity_limit
            assert mine.torque_limit == joint.torque_limit
    (sentence,) = robot.assumed_figures
    assert re.search(rf"a placeholder: the limits of the shipped robot '{name}'", sentence)


def test_limits_that_a_cell_narrows_are_kept(read):
    ours = load_robot("ur5e")
    robot = read(urdf(ours, reach=1.5))
    assert {joint.upper for joint in robot.arm_joints} == {1.5}
    assert robot.assumed_figures == ()


def weights(robot: Robot, postures: int = 40) -> dict[str, float]:
    """Return the most that gravity asks of each joint of an arm in random postures [N m or N]."""
    model = compile_model(robot)
    data = mujoco.MjData(model)
    random = np.random.default_rng(0)
    most = dict.fromkeys((joint.name for joint in robot.arm_joints), 0.0)
    for _ in range(postures):
        for joint in robot.arm_joints:
            angle = random.uniform(max(joint.lower, -np.pi), min(joint.upper, np.pi))
            data.qpos[model.joint(joint.name).qposadr[0]] = angle
        mujoco.mj_inverse(model, data)
        for name in most:
            most[name] = max(most[name], abs(data.qfrc_inverse[model.joint(name).dofadr[0]]))
    return most


def test_every_shipped_arm_holds_itself_in_any_posture():
    robots = [load_robot(each.name) for each in shipped_names()]
    weak = {
        (robot.name, name): (weight, robot.joint(name).torque_limit)
        for robot in robots
        for name, weight in weights(robot).items()
        if weight > robot.joint(name).torque_limit
    }
    assert not weak


@pytest.mark.parametrize("name", ["widowx", "px100", "mycobot_280", "irb120"])
def test_an_arm_with_heavy_placeholders_for_masses_keeps_a_torque_that_holds_them(read, name):
    robot = read(urdf(load_robot(name), effort=6.0, mass=3.0))
    asked = weights(robot)
    assert max(asked.values()) > 6.0
    assert all(robot.joint(joint).torque_limit > weight for joint, weight in asked.items())
