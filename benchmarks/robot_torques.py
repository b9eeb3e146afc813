"""Compare the torques of a robot's joints with those of public models of its dynamics.

    python benchmarks/robot_torques.py [--robot NAME] [--moves N] [--scaling S]

The twin drives random moves between configurations within the limits; at each step the public
model says which torque that motion takes. Printed is the root mean square of both for each joint,
as a part of the joint's limit, and their difference. The exit code is 1 when a joint that carries
more than 5 % of its limit differs by more than 5 %.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import quick
from numpy.typing import NDArray

from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.motion import JointTrajectory
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.recording.samples import Samples, SampleWriter, read_samples
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_parts import Link, Scaling
from tracerisk.twin.simulation.twin import Twin

# After the builder, which says that no window is needed.
import mujoco  # isort: skip

MOST = 0.05
LOADED = 0.05
STEP_NS = 20_000_000
FLAT = (0.0, 0.0, 0.0)
NOWHERE = Scene("nowhere", "nothing to touch", FLAT, FLAT, (), (), (), "robot_torques.py")

Array = NDArray[np.float64]
Body = tuple[float, tuple[float, float, float], tuple[float, float, float, float, float, float]]


@dataclass(frozen=True, slots=True)
class PublicModel:
    """A public model of an arm's dynamics."""

    source: str
    """Where the figures are from."""

    bodies: dict[str, Body]
    """Mass [kg], centre of mass [m], inertia about it (xx, yy, zz, xy, xz, yz) [kg m^2]."""

    friction: tuple[tuple[float, float, float], ...] = ()
    """A [N m], alpha [s/rad] and offset [rad/s] of each joint's sigmoid."""


PUBLIC = {
    "panda": PublicModel(
        "C. Gaz et al., Dynamic Identification of the Franka Emika Panda Robot With Retrieval of "
        "Feasible Parameters Using Penalty-Based Optimization, RA-L 2019; parameters as in "
        "google-deepmind/mujoco_menagerie franka_emika_panda/panda.xml, friction as in "
        "marcocognetti/FrankaEmikaPandaDynModel get_FrictionTorque.m",
        {
            "panda_link1": (4.970684, (3.875e-3, 2.081e-3, -4.762e-2),
                            (0.70337, 0.70661, 9.117e-3, -1.39e-4, 6.772e-3, 1.9169e-2)),
            "panda_link2": (0.646926, (-3.141e-3, -2.872e-2, 3.495e-3),
                            (7.962e-3, 2.811e-2, 2.5995e-2, -3.925e-3, 1.0254e-2, 7.04e-4)),
            "panda_link3": (3.228604, (2.7518e-2, 3.9252e-2, -6.6502e-2),
                            (3.7242e-2, 3.6155e-2, 1.083e-2, -4.761e-3, -1.1396e-2, -1.2805e-2)),
            "panda_link4": (3.587895, (-5.317e-2, 0.104419, 2.7454e-2),
                            (2.5853e-2, 1.9552e-2, 2.8323e-2, 7.796e-3, -1.332e-3, 8.641e-3)),
            "panda_link5": (1.225946, (-1.1953e-2, 4.1065e-2, -3.8437e-2),
                            (3.5549e-2, 2.9474e-2, 8.627e-3, -2.117e-3, -4.037e-3, 2.29e-4)),
            "panda_link6": (1.666555, (6.0149e-2, -1.4117e-2, -1.0517e-2),
                            (1.964e-3, 4.354e-3, 5.433e-3, 1.09e-4, -1.158e-3, 3.41e-4)),
            "panda_link7": (0.735522, (1.0517e-2, -4.252e-3, 6.1597e-2),
                            (1.2516e-2, 1.0027e-2, 4.815e-3, -4.28e-4, -1.196e-3, -7.41e-4)),
        },
        (
            (0.54615, 5.1181, 0.039533), (0.87224, 9.0657, 0.025882),
            (0.64068, 10.136, -0.04607), (1.2794, 5.5903, 0.036194),
            (0.83904, 8.3469, 0.026226), (0.30301, 17.133, -0.021047),
            (0.56489, 10.336, 0.0035526),
        ),
    ),
    "ur5e": PublicModel(
        "Universal Robots, DH parameters for calculations of kinematics and dynamics: masses and "
        "centres of mass; it calls the inertias of this arm negligible, and those of "
        "UniversalRobots/Universal_Robots_ROS2_Description config/ur5e are taken",
        {
            "shoulder_link": (3.761, (0.0, -0.00193, -0.02561),
                              (0.0102675, 0.0102675, 0.00666, 0.0, 0.0, 0.0)),
            "upper_arm_link": (8.058, (-0.2125, 0.0, 0.11336),
                               (0.0151074, 0.1338858, 0.1338858, 0.0, 0.0, 0.0)),
            "forearm_link": (2.846, (-0.2422, 0.0, 0.0265),
                             (0.004095, 0.0312094, 0.0312094, 0.0, 0.0, 0.0)),
            "wrist_1_link": (1.37, (0.0, -0.01634, -0.0018),
                             (0.0025599, 0.0025599, 0.0021942, 0.0, 0.0, 0.0)),
            "wrist_2_link": (1.3, (0.0, 0.01634, -0.0018),
                             (0.0025599, 0.0025599, 0.0021942, 0.0, 0.0, 0.0)),
            "wrist_3_link": (0.365, (0.0, 0.0, -0.001159),
                             (9.8904e-05, 9.8904e-05, 1.321171e-4, 0.0, 0.0, 0.0)),
        },
    ),
}  # fmt: skip


def as_public(robot: Robot, public: PublicModel) -> Robot:
    """Return the robot with the bodies of a public model, without rotors and friction."""

    def body(link: Link) -> Link:
        if link.name not in public.bodies:
            return link
        mass, centre, inertia = public.bodies[link.name]
        return dataclasses.replace(link, mass=mass, centre_of_mass=centre, inertia=inertia)

    bare = [
        dataclasses.replace(
            joint, servo=dataclasses.replace(joint.servo, armature=0.0, friction=0.0)
        )
        for joint in robot.joints
    ]
    return dataclasses.replace(robot, links=tuple(map(body, robot.links)), joints=tuple(bare))


def driven(robot: Robot, moves: int, scaling: float) -> Samples:
    """Return the samples of random moves of the twin."""
    random = np.random.default_rng(1)
    arm = robot.arm_joints
    names = tuple(joint.name for joint in arm)
    # An endless joint turns once at most, and none comes near its stops.
    low = np.array([max(joint.lower, -np.pi) for joint in arm])
    high = np.array([min(joint.upper, np.pi) for joint in arm])
    with tempfile.TemporaryDirectory() as folder:
        writer = SampleWriter(Path(folder))
        twin = Twin.build(robot, NOWHERE, samples=writer)
        here = np.array([robot.initial_state[name] for name in names])
        for _ in range(moves):
            goal = low + (high - low) * random.uniform(0.1, 0.9, len(arm))
            rows = np.array([here, goal])
            path = JointTrajectory(names, np.array([0.0, 1.0]), rows, np.zeros_like(rows))
            timed = twin.retime(path, scaling=Scaling(scaling, scaling))
            motion = twin.follow(timed)
            while motion.outcome == "active":
                twin.advance(twin.time_ns + STEP_NS)
            here = goal
        twin.close()
        return read_samples(Path(folder))


def asked(robot: Robot, public: PublicModel, samples: Samples) -> Array:
    """Return the torques that the public model asks for the sampled motion, (n_steps, n_joints)."""
    model = compile_model(as_public(robot, public))
    data = mujoco.MjData(model)
    names = samples.header.joints
    places = [int(model.joint(name).qposadr[0]) for name in names]
    freedoms = [int(model.joint(name).dofadr[0]) for name in names]
    acceleration = np.gradient(samples.velocity, samples.step_s, axis=0)
    zeros_like = np.zeros_like(samples.torque)
    for row in range(samples.n_steps):
        data.qpos[places] = samples.position[row]
        data.qvel[freedoms] = samples.velocity[row]
        data.qacc[freedoms] = acceleration[row]
        mujoco.mj_inverse(model, data)
        zeros_like[row] = data.qfrc_inverse[freedoms]
    for column, (height, slope, offset) in enumerate(public.friction):
        zeros_like[:, column] += height * (
            _sigmoid(slope * (samples.velocity[:, column] + offset)) - _sigmoid(slope * offset)
        )
    return zeros_like


def _sigmoid(x: Array | float) -> Array:
    return np.asarray(1.0 / (1.0 + np.exp(-np.asarray(x))))


def rms(values: Array) -> Array:
    """Return the root mean square of each column."""
    return np.asarray(np.sqrt((values**2).mean(axis=0)))


def compared(name: str, moves: int, scaling: float) -> list[tuple[str, float, float, bool]]:
    """Return for each joint its rms torque here and there, over its limit, and if they agree."""
    robot = load_robot(name)
    samples = driven(robot, moves, scaling)
    # While an arm stands, its torque is that of its weight, which moves measure as well.
    moving = np.abs(samples.velocity).max(axis=1) > 0.01
    ours, theirs = rms(samples.torque[moving]), rms(asked(robot, PUBLIC[name], samples)[moving])
    rows = []
    for joint in robot.arm_joints:
        column = samples.header.joints.index(joint.name)
        here, there = ours[column] / joint.torque_limit, theirs[column] / joint.torque_limit
        agrees = max(here, there) <= LOADED or abs(here - there) <= MOST * there
        rows.append((joint.name, float(here), float(there), bool(agrees)))
    return rows


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robot", action="append", choices=sorted(PUBLIC))
    parser.add_argument("--moves", type=int, default=20)
    parser.add_argument("--scaling", type=float, default=0.5)
    options = quick.parsed(parser, arguments, robot=lambda: ["panda"], moves=lambda: 2)
    agree = True
    for name in options.robot or sorted(PUBLIC):
        print(f"{name}: {PUBLIC[name].source}")
        for joint, here, there, agrees in compared(name, options.moves, options.scaling):
            note = "" if agrees else "  differs"
            print(f"    {joint:24} {here:7.2%} there {there:7.2%} {here / there - 1:+7.1%}{note}")
            agree &= agrees
    return 0 if options.quick or agree else 1


if __name__ == "__main__":
    sys.exit(main())
