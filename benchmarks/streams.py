"""Compare what one smooth motion takes of an arm when it is streamed at several rates.

    python benchmarks/streams.py [--robot NAME] [--rate HZ] [--waves N]

All joints go to and fro together, and set-points of that motion come at each rate, as positions
and as velocities. Printed is for each joint the root mean square of the torque over that of inverse
dynamics for the smooth motion itself. The exit code is 1 where one differs by more than 5 %, or an
exposure by more than 1 % between the rates.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import quick
from numpy.typing import NDArray

from tracerisk.common.traced.elements import WEAR_EXPONENTS
from tracerisk.ros.robot.streams.command_streams import VelocityStream
from tracerisk.twin.motion.streams import SetPointStream
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.motion import STEP_S, JointTrajectory
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.recording.activity import element_activity
from tracerisk.twin.recording.exposure import exposure
from tracerisk.twin.recording.samples import Samples, SampleWriter, read_samples
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.simulation.twin import Twin

# After the builder, which says that no window is needed.
import mujoco  # isort: skip

Array = NDArray[np.float64]
Quantity = Literal["position", "velocity"]

ROBOTS = ("ur5e", "panda", "xarm7", "gen3")
RATES_HZ = (20.0, 50.0, 125.0, 500.0)
PERIOD_S = 4.0
MOST_TORQUE, MOST_EXPOSURE = 0.05, 0.01
LEAST = 0.01
"""A torque below this fraction of a joint's limit is no load [1]."""
LOADED = 0.05
"""The fraction of a joint's limit from which its wear counts, as in robot_torques.py [1]."""
_CUBIC = WEAR_EXPONENTS.index(3.0)
FLAT = (0.0, 0.0, 0.0)
NOWHERE = Scene("nowhere", "nothing to touch", FLAT, FLAT, (), (), (), "streams.py")


@dataclass(frozen=True, slots=True)
class Wave:
    """All joints of an arm to and fro from where it begins, at rest at both ends."""

    names: tuple[str, ...]
    """The joints of the arm."""
    start: Array
    """Where they begin, (n_joints,) [rad]."""
    way: Array
    """How far they go, (n_joints,) [rad]."""
    duration_s: float
    """How long it lasts [s]."""

    def at(self, time_s: float) -> tuple[Array, Array, Array]:
        """Return positions, velocities and accelerations at a time, (n_joints,)."""
        turn = 2.0 * np.pi / PERIOD_S
        phase = turn * min(max(time_s, 0.0), self.duration_s)
        position = self.start + self.way * (1.0 - np.cos(phase)) / 2.0
        moves = 0.0 <= time_s <= self.duration_s
        velocity = self.way * turn * np.sin(phase) / 2.0 * moves
        return position, velocity, self.way * turn**2 * np.cos(phase) / 2.0 * moves


def wave_of(robot: Robot, waves: int) -> Wave:
    """Return the motion of a robot, towards the further limit of each joint."""
    arm = robot.arm_joints
    start = np.array([robot.initial_state[joint.name] for joint in arm])
    above = np.array([joint.upper for joint in arm]) - start
    below = start - np.array([joint.lower for joint in arm])
    way = np.where(above >= below, 1.0, -1.0) * np.minimum(np.maximum(above, below) / 3.0, 0.5)
    return Wave(tuple(joint.name for joint in arm), start, way, waves * PERIOD_S)


def streamed(robot: Robot, wave: Wave, rate_hz: float, quantity: Quantity) -> Samples:
    """Return what the twin does when the motion is streamed at a rate."""
    with tempfile.TemporaryDirectory() as folder:
        twin = Twin.build(robot, NOWHERE, samples=SampleWriter(Path(folder)))
        positions, velocities = SetPointStream(robot, wave.names), VelocityStream(twin)
        for number in range(round(wave.duration_s * rate_hz) + 1):
            due_ns = round(number / rate_hz * 1e9)
            while twin.time_ns < due_ns:
                twin.advance(due_ns)
            position, velocity, _ = wave.at(number / rate_hz)
            if quantity == "position":
                now_s = twin.time_ns * 1e-9
                positions.take(due_ns * 1e-9, position, twin.reference(wave.names), now_s)
                twin.follow(JointTrajectory(wave.names, *positions.way(now_s, STEP_S)))
            else:
                asked = dict(zip(wave.names, velocity.tolist(), strict=True))
                made = velocities.next(asked, due_ns, None)
                if made is not None:
                    twin.follow(made)
        if quantity == "velocity":
            twin.stop()
        end_ns = twin.time_ns + 500_000_000
        while twin.time_ns < end_ns:
            twin.advance(end_ns)
        twin.close()
        return read_samples(Path(folder))


def asked(robot: Robot, wave: Wave) -> Array:
    """Return the torques that the smooth motion asks for at each step, (n_steps, n_joints)."""
    model = compile_model(robot)
    data = mujoco.MjData(model)
    for joint in robot.joints:
        data.qpos[int(model.joint(joint.name).qposadr[0])] = robot.initial_state[joint.name]
    places = [int(model.joint(name).qposadr[0]) for name in wave.names]
    freedoms = [int(model.joint(name).dofadr[0]) for name in wave.names]
    # The sensor of a servo's torque reads the speed at the begin of a step, and its damping acts
    # on that at the end.
    lead = np.array([joint.servo.damping for joint in robot.arm_joints]) * STEP_S
    result = []
    for step in range(round(wave.duration_s / STEP_S)):
        data.qpos[places], data.qvel[freedoms], data.qacc[freedoms] = wave.at(step * STEP_S)
        mujoco.mj_inverse(model, data)
        result.append(data.qfrc_inverse[freedoms] + lead * data.qacc[freedoms])
    return np.array(result)


def rms(values: Array) -> Array:
    """Return the root mean square of each column."""
    return np.asarray(np.sqrt((values**2).mean(axis=0)))


def compared(
    robot: Robot, rates_hz: Sequence[float], waves: int, quantity: Quantity
) -> tuple[dict[float, Array], float, float]:
    """Return torques over those asked for, by rate, and the greatest differences of both kinds."""
    wave = wave_of(robot, waves)
    theirs = rms(asked(robot, wave))
    limits = np.array([joint.torque_limit for joint in robot.arm_joints])
    shares: dict[float, Array] = {}
    exposures: list[Array] = []
    for rate_hz in rates_hz:
        samples = streamed(robot, wave, rate_hz, quantity)
        columns = [samples.header.joints.index(name) for name in wave.names]
        moving = np.abs(samples.velocity[:, columns]).max(axis=1) > 1e-3
        shares[rate_hz] = rms(samples.torque[:, columns][moving]) / theirs
        activity = element_activity(samples, robot, only=wave.names)
        everywhere = np.ones(samples.n_steps, dtype=np.bool_)
        each = [exposure(activity[name], everywhere, samples.step_s) for name in wave.names]
        exposures.append(np.array([(one.moving_s, one.travel_s, one.wear[_CUBIC]) for one in each]))
    torque = max(
        float(np.abs(share - 1.0)[theirs > LEAST * limits].max()) for share in shares.values()
    )
    spread = np.max(exposures, axis=0) / np.min(exposures, axis=0) - 1.0
    # What a joint without a load wears by the cube of it is as good as nothing.
    spread[theirs <= LOADED * limits, 2] = 0.0
    return shares, torque, float(spread.max())


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robot", action="append")
    parser.add_argument("--rate", action="append", type=float)
    parser.add_argument("--waves", type=int, default=3)
    options = quick.parsed(
        parser, arguments, robot=lambda: ["ur5e"], rate=lambda: [50.0, 125.0], waves=lambda: 1
    )
    agree = True
    quantities: tuple[Quantity, ...] = ("position", "velocity")
    for name in options.robot or ROBOTS:
        robot = load_robot(name)
        for quantity in quantities:
            rates = options.rate or RATES_HZ
            shares, torque, spread = compared(robot, rates, options.waves, quantity)
            print(f"{name}, {quantity}: torques within {torque:.1%}, exposures within {spread:.2%}")
            for rate_hz, share in shares.items():
                print(f"    {rate_hz:5g} Hz  " + " ".join(f"{item:6.3f}" for item in share))
            agree &= torque <= MOST_TORQUE and spread <= MOST_EXPOSURE
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
