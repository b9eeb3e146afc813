from dataclasses import replace

import numpy as np
import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.physics.builder import SensorLayout, compile_model, place_robot
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.robots.robot import Robot

import mujoco  # isort: skip

# Denavit-Hartenberg parameters (Craig's convention: a, d, alpha) and the flange's d, from the
# maker's table: github.com/frankaemika/docs, source/control_parameters.rst, said to be the Panda's
# up to commit 321d1f1 and, unchanged, the Franka Research 3's since.
PANDA_DH = [
    (0.0, 0.333, 0.0),
    (0.0, 0.0, -np.pi / 2),
    (0.0, 0.316, np.pi / 2),
    (0.0825, 0.0, np.pi / 2),
    (-0.0825, 0.384, -np.pi / 2),
    (0.0, 0.0, np.pi / 2),
    (0.088, 0.0, np.pi / 2),
]
FLANGE = 0.107


def flange_by_dh(q: np.ndarray) -> np.ndarray:
    pose = np.eye(4)
    for (a, d, alpha), theta in zip(PANDA_DH, q, strict=True):
        ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        pose = pose @ np.array(
            [
                [ct, -st, 0, a],
                [st * ca, ct * ca, -sa, -d * sa],
                [st * sa, ct * sa, ca, d * ca],
                [0, 0, 0, 1],
            ]
        )
    return pose @ np.array([0.0, 0.0, FLANGE, 1.0])


def test_kinematics_are_the_published_ones(panda: Robot):
    kinematics = Kinematics(panda)
    generator = np.random.default_rng(3)
    for _ in range(50):
        q = np.array([generator.uniform(joint.lower, joint.upper) for joint in panda.arm_joints])
        positions = {joint.name: float(v) for joint, v in zip(panda.arm_joints, q, strict=True)}
        found = kinematics.forward(positions, "panda_link8").position
        assert found == pytest.approx(flange_by_dh(q)[:3], abs=1e-9)


def test_the_mass_is_the_sum_of_the_links(panda: Robot):
    model = compile_model(panda)
    assert float(model.body_mass.sum()) == pytest.approx(sum(link.mass for link in panda.links))


def test_limits_reach_the_model(panda: Robot):
    model = compile_model(panda)
    for joint in panda.joints:
        index = model.joint(joint.name).id
        assert tuple(model.jnt_range[index]) == (joint.lower, joint.upper)
        assert tuple(model.jnt_actfrcrange[index]) == (-joint.torque_limit, joint.torque_limit)


def test_sensors_stand_where_the_layout_says(panda: Robot, tube_racks: Scene):
    model = compile_model(panda, tube_racks)
    data = mujoco.MjData(model)
    place_robot(model, data, panda)
    layout = SensorLayout.of(panda)
    initial = [panda.initial_state[joint.name] for joint in panda.joints]
    assert data.sensordata[layout.position].tolist() == initial
    dofs = [int(model.joint(joint.name).dofadr[0]) for joint in panda.joints]
    assert data.sensordata[layout.torque].tolist() == data.qfrc_actuator[dofs].tolist()
    assert len(data.sensordata) == layout.touching.stop


def test_an_arm_joint_whose_servo_has_no_stiffness_is_named(panda: Robot):
    first, *others = panda.joints
    limp = replace(first, servo=replace(first.servo, stiffness=0.0))
    with pytest.raises(RobotError, match=f"'{first.name}' has stiffness 0 and cannot move it"):
        compile_model(replace(panda, joints=(limp, *others)))
