"""The figures of the shipped robots: where they come from, and those that sources dispute."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.physics.motion import JointTrajectory, Pose
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot, robot_names
from tracerisk.twin.robots.robot_parts import Scaling
from tracerisk.twin.simulation.twin import Twin

# After the twin, which says that no window is needed.
import mujoco  # isort: skip

KINDS = (
    "kinematics",
    "limits",
    "speed",
    "torque",
    "mass",
    "acceleration",
    "default scaling",
    "group",
    "controller",
)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", robot_names())
def test_its_source_is_named_for_each_kind_of_figure(name: str, kind: str):
    assert kind in load_robot(name).source.lower()


@pytest.mark.parametrize("name", robot_names())
def test_it_plans_at_most_as_fast_as_it_is_rated(name: str):
    for joint in load_robot(name).joints:
        assert 0.0 < joint.planned_velocity <= joint.velocity_limit
        assert 0.0 < joint.planned_acceleration <= joint.acceleration_limit


# The links of the robot's file, with its hand [kg]: totals of the public files that it names.
MASSES = {
    "gen3": 7.22,
    "iiwa14": 29.9,
    "panda": 16.77,
    "ur10e": 29.10,
    "ur5e": 17.70,
    "xarm6": 10.06,
    "xarm7": 11.14,
}


@pytest.mark.parametrize(("name", "mass"), MASSES.items())
def test_its_links_weigh_what_their_source_says(name: str, mass: float):
    assert sum(link.mass for link in load_robot(name).links) == pytest.approx(mass, abs=0.01)


@pytest.mark.parametrize(
    ("name", "joint", "velocity", "acceleration"),
    [
        ("xarm7", "joint1", 2.14, 1.0),
        ("gen3", "joint_1", 1.3963, 8.6),
        ("ur5e", "wrist_3_joint", math.pi, 5.0),
        ("ur10", "shoulder_pan_joint", 2.0944, 5.0),
        ("baxter", "left_s0", 0.75, 2.0),
        ("sawyer", "right_j6", 2.316, 5.0),
        ("fetch", "shoulder_lift_joint", 1.0, 1.0),
        ("wx250s", "elbow", 2.35, 5.0),
        ("j2n6s300", "j2n6s300_joint_1", 0.35, 1.0),
        ("iiwa14_stack", "iiwa_joint_1", 1.4835, 1.0),
    ],
)
def test_it_plans_with_the_limits_of_its_moveit_configuration(
    name: str, joint: str, velocity: float, acceleration: float
):
    found = load_robot(name).joint(joint)
    assert found.planned_velocity == pytest.approx(velocity, rel=1e-4)
    assert found.planned_acceleration == pytest.approx(acceleration, rel=1e-4)


def test_the_rated_speed_of_an_arm_is_not_that_of_its_plans():
    xarm = load_robot("xarm7")
    joint = xarm.joint("joint1")
    assert (joint.velocity_limit, joint.acceleration_limit) == (3.14, 20.0)
    way = JointTrajectory(
        ("joint1",), np.array([0.0, 9.0]), np.array([[-6.0], [6.0]]), np.zeros((2, 1))
    )
    twin = Twin.build(xarm, load_scene("empty"))
    timed = twin.retime(way, scaling=Scaling(1.0, 1.0))
    assert np.abs(timed.velocity).max() == pytest.approx(2.14, rel=1e-3)


@pytest.mark.parametrize("side", ["left", "right"])
def test_baxters_gripper_ends_at_the_tips_of_its_long_fingers(side: str):
    baxter = Kinematics(load_robot("baxter"))
    hand, tip = (baxter.forward({}, f"{side}_{end}") for end in ("hand", "gripper"))
    # 25 mm to the base of the gripper, 20 mm to the fingers, and fingers of 112.7 mm.
    assert math.dist(hand.position, tip.position) == pytest.approx(0.025 + 0.02 + 0.1127, abs=1e-6)


@pytest.mark.parametrize(("joint", "torque"), [("lbr_A1", 320.0), ("lbr_A3", 176.0)])
def test_torques_of_the_iiwa_are_those_of_its_brochure(joint: str, torque: float):
    assert load_robot("iiwa14").joint(joint).torque_limit == torque


# Gravity torques [N m] of the arm without a hand, by the closed form that the identified model is
# published with: marcocognetti/FrankaEmikaPandaDynModel, get_GravityVector.m.
IDENTIFIED = [
    (
        (0.0, -0.78, 0.0, -2.35, 0.0, 1.57, 0.78),
        (0.000, -1.877, -0.665, 18.520, 0.716, 1.672, 0.000),
    ),
    (
        (0.3, 0.9, -0.5, -1.2, 0.8, 2.2, -0.4),
        (0.000, -45.384, -7.999, 17.795, 0.481, 1.668, -0.014),
    ),
]


def turned(pose: Pose, vector: Sequence[float]) -> np.ndarray:
    x, y, z, w = pose.orientation
    found = np.zeros(3)
    mujoco.mju_rotVecQuat(found, np.array(vector), np.array([w, x, y, z]))
    return found


@pytest.mark.parametrize(("positions", "torques"), IDENTIFIED)
def test_the_pandas_links_weigh_on_its_joints_as_identified(
    positions: tuple[float, ...], torques: tuple[float, ...]
):
    panda = load_robot("panda")
    kinematics = Kinematics(panda)
    arm = [link for link in panda.links if link.name.startswith("panda_link")]
    names = [f"panda_joint{i}" for i in range(1, 8)]

    def energy(at: np.ndarray) -> float:
        poses = kinematics.forward_all(dict(zip(names, at.tolist(), strict=True)))
        heights = [
            poses[link.name].position[2] + turned(poses[link.name], link.centre_of_mass)[2]
            for link in arm
        ]
        return 9.80665 * sum(link.mass * height for link, height in zip(arm, heights, strict=True))

    at, step = np.array(positions), 1e-4 * np.eye(7)
    found = [(energy(at + each) - energy(at - each)) / 2e-4 for each in step]
    assert found == pytest.approx(torques, abs=0.1)
