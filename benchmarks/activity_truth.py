"""Compare the activity that the twin finds with what was commanded and with inverse dynamics.

    python benchmarks/activity_truth.py [PROGRAM...]

Each program commands motions that are known in closed form (or as points in time), so that the
steps in which a joint moves are known; whether it holds at the others follows from the torque that
MuJoCo's inverse dynamics give for the commanded motion. The table has, for each program, precision
and recall of moving and holding over all steps and elements, the grasps found and true, and the
greatest error of an element's seconds. Exits 1 where a figure is out of its bounds.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import quick
from activity_programs import PROGRAMS, Bench, Program
from numpy.typing import NDArray

from tracerisk.twin.physics.builder import build_spec
from tracerisk.twin.physics.motion import STEP_S
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.activity import ElementActivity, element_activity
from tracerisk.twin.recording.joint_motion import runs
from tracerisk.twin.recording.samples import SampleWriter, read_samples
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.simulation.twin import Twin

import mujoco  # isort: skip

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEAST = 0.98
"""Precision and recall of moving and holding, at least."""
MOST_RELATIVE, MOST_S = 0.02, 0.05
"""An element's seconds may be off by this share, or by these seconds, whichever is more."""
FAR_ENOUGH = 1e-3
"""A joint that is commanded to go less far does not move, by definition [rad]."""
HOLDS = 0.02
"""The torque from which a joint at rest holds, of its limit."""


@dataclass(frozen=True)
class Truth:
    """What an element does at each step, (n_steps,); `known` says where holding is known."""

    moving: Flags
    holding: Flags
    grasping: Flags
    known: Flags


@dataclass(frozen=True)
class Score:
    """How what was found compares; precision and recall are 1 where there is nothing."""

    program: str
    moving: tuple[float, float]
    holding: tuple[float, float]
    grasps: tuple[int, int, int]
    """Right, found and true."""
    worst: tuple[str, float, float]
    """The element and state whose seconds are furthest beyond what is allowed; found, true [s]."""
    excess: float
    """The greatest error of an element's seconds, of what is allowed."""

    @property
    def is_good(self) -> bool:
        right, number, true = self.grasps
        ratios = (*self.moving, *self.holding)
        return min(ratios) >= LEAST and right == number == true and self.excess <= 1.0


def truths(bench: Bench, n_steps: int) -> dict[str, Truth]:
    """Return what each joint and gripper truly does."""
    robot = bench.robot
    arm = [joint.name for joint in robot.arm_joints]
    state = robot.initial_state
    reference = np.tile([state[name] for name in arm], (n_steps, 1))
    moving = {name: np.zeros(n_steps, dtype=np.bool_) for name in arm}
    for commanded in sorted(bench.commanded, key=lambda commanded: commanded.start_s):
        first = round(commanded.start_s / STEP_S)
        for column, name in enumerate(commanded.joints):
            path = commanded.position[:, column]
            stop = min(first + len(path) - 1, n_steps)
            at = arm.index(name)
            reference[first:stop, at] = path[: stop - first]
            reference[stop:, at] = path[-1]
            if np.ptp(path) >= FAR_ENOUGH:
                moving[name][first:stop] = True
    torque = inverse_dynamics(bench, reference)
    free = np.ones(n_steps, dtype=np.bool_)
    for begin_s, end_s in bench.touching:
        free[round(begin_s / STEP_S) : round(end_s / STEP_S)] = False
    nothing = np.zeros(n_steps, dtype=np.bool_)
    table = {}
    for column, name in enumerate(arm):
        load = np.abs(torque[:, column]) / robot.joint(name).torque_limit
        table[name] = Truth(moving[name], (load > HOLDS) & ~moving[name], nothing, free)
    for gripper in robot.grippers:
        spans = [span for name, *span in bench.fingers if name == gripper.name]
        grasps = [span for name, *span in bench.grasps if name == gripper.name]
        fingers, grasping = _within(spans, n_steps), _within(grasps, n_steps)
        table[gripper.name] = Truth(fingers, grasping & ~fingers, grasping, free)
    return table


def _within(spans: Sequence[Sequence[float]], n_steps: int) -> Flags:
    flags = np.zeros(n_steps, dtype=np.bool_)
    for start, stop in spans:
        flags[round(start / STEP_S) : round(stop / STEP_S)] = True
    return flags


def inverse_dynamics(bench: Bench, reference: Array) -> Array:
    """Return the torques of the arm joints that the commanded motion needs, (n_steps, n_joints).

    Without contacts; what a hand holds is a mass at its tool centre point.
    """
    bare = _model(bench.robot, None)
    loaded = [
        (_model(bench.robot, (gripper, mass)), _within([(start, stop)], len(reference)))
        for gripper, mass, start, stop in bench.payloads
    ]
    velocity = np.gradient(reference, STEP_S, axis=0)
    acceleration = np.gradient(velocity, STEP_S, axis=0)
    torque = np.zeros_like(reference)
    for step in range(len(reference)):
        model = next((model for model, when in loaded if when[step]), bare)
        torque[step] = _torque(model, reference[step], velocity[step], acceleration[step])
    return torque


@dataclass(frozen=True)
class _Model:
    model: Any
    data: Any
    positions: Array
    dofs: Array


def _model(robot: Robot, payload: tuple[str, float] | None) -> _Model:
    spec = build_spec(robot)
    off = mujoco.mjtDisableBit
    spec.option.disableflags |= int(off.mjDSBL_CONSTRAINT)
    if payload is not None:
        gripper, mass = payload
        pad = robot.gripper(gripper).pads[0]
        hand = next(
            attachment.parent for attachment in robot.attachments if attachment.child == pad
        )
        thing = spec.body(hand).add_body(name="payload", pos=(0.0, 0.0, 0.1034))
        thing.explicitinertial = True
        thing.mass, thing.inertia = mass, (1e-5, 1e-5, 1e-5)
    model = spec.compile()
    data = mujoco.MjData(model)
    state = robot.initial_state
    for joint in robot.joints:
        data.qpos[model.joint(joint.name).qposadr[0]] = state[joint.name]
    joints = [model.joint(joint.name) for joint in robot.arm_joints]
    return _Model(
        model,
        data,
        np.array([item.qposadr[0] for item in joints]),
        np.array([item.dofadr[0] for item in joints]),
    )


def _torque(on: _Model, position: Array, velocity: Array, acceleration: Array) -> Array:
    on.data.qpos[on.positions] = position
    on.data.qvel[on.dofs] = velocity
    on.data.qacc[on.dofs] = acceleration
    mujoco.mj_inverse(on.model, on.data)
    torque: Array = on.data.qfrc_inverse[on.dofs].copy()
    return torque


def score(program: Program) -> Score:
    """Run a program and compare what was found with what is true."""
    with tempfile.TemporaryDirectory() as folder:
        robot = load_robot(program.robot)
        twin = Twin.build(robot, load_scene(program.scene), samples=SampleWriter(Path(folder)))
        bench = Bench(robot, twin)
        program.run(bench)
        twin.close()
        samples = read_samples(Path(folder))
    element_activities = element_activity(samples, robot)
    return compare(program.name, element_activities, truths(bench, samples.n_steps))


def compare(program: str, found: Mapping[str, ElementActivity], true: Mapping[str, Truth]) -> Score:
    """Return how the activity found compares with the true one."""
    counts = {"moving": np.zeros(3), "holding": np.zeros(3)}
    grasps = np.zeros(3, dtype=np.int64)
    worst: tuple[str, float, float] = ("", 0.0, 0.0)
    excess = 0.0
    for name, truth in true.items():
        for state in ("moving", "holding", "grasping"):
            # Where holding is not known, neither is what was found of it.
            known = truth.known if state == "holding" else np.ones_like(truth.known)
            is_found, is_true = getattr(found[name], state) & known, getattr(truth, state) & known
            if state == "grasping":
                right = sum(bool(is_found[a:b].any()) for a, b in zip(*runs(is_true), strict=True))
                grasps += (right, len(runs(is_found)[0]), len(runs(is_true)[0]))
            else:
                counts[state] += ((is_found & is_true).sum(), is_found.sum(), is_true.sum())
            seconds = float(is_found.sum()) * STEP_S, float(is_true.sum()) * STEP_S
            allowed = max(MOST_RELATIVE * seconds[1], MOST_S)
            error = abs(seconds[0] - seconds[1]) / allowed
            if error > excess:
                worst, excess = (f"{name} {state}", *seconds), error
    ratios = {
        state: (
            right / found_steps if found_steps else 1.0,
            right / true_steps if true_steps else 1.0,
        )
        for state, (right, found_steps, true_steps) in counts.items()
    }
    right, n_found, n_true = grasps.tolist()
    return Score(
        program, ratios["moving"], ratios["holding"], (right, n_found, n_true), worst, excess
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs="*", metavar="PROGRAM", help="parts of their names")
    options = quick.parsed(parser, programs=lambda: ["gripper on nothing"])
    chosen = [
        item
        for item in PROGRAMS
        if not options.programs or any(part in item.name for part in options.programs)
    ]
    last = "furthest off: found, true [s]"
    print(f"{'program':28} {'moving':>13} {'holding':>13} {'grasps':>8}  {last}")
    good = True
    for program in chosen:
        row = score(program)
        good &= row.is_good
        what, seconds, truly = row.worst
        moving, holding = (f"{p:.3f} {r:.3f}" for p, r in (row.moving, row.holding))
        grasps = "/".join(map(str, row.grasps))
        mark = "" if row.is_good else "  OUT OF BOUNDS"
        print(
            f"{row.program:28} {moving:>13} {holding:>13} {grasps:>8}  "
            f"{what} {seconds:.3f}, {truly:.3f}{mark}"
        )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
