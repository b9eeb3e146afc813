"""Which solutions of the inverse kinematics pose goals take, beside all that there are.

    python benchmarks/whole_turns.py [--robots NAME...] [--goals N]

Chains of goals with the tool down, on each shipped arm with a joint whose range exceeds a whole
turn. Each goal is reached from the solution of the one before. The solutions beside which it is
judged are those of scalar descents from random positions, with the pull of the joints towards
where they are, and all whole turns within limits: they share no code with the twin's search.
A whole turn is needless where a joint could come to the same direction by a shorter way within its
limits. Travel is the sum over the goals of the root of the joints' squared moves.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Sequence

import mujoco
import numpy as np
import quick
from numpy.typing import NDArray

from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.motion import PlanningError, Pose
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.robots.robot_parts import Joint

Array = NDArray[np.float64]

TURN = 2 * math.pi
_DESCENTS, _STEPS = 24, 30
_ALONG_X = {"fetch"}
"""The arms whose tool points along x of the tip link; that of the others along z."""


class Referee:
    """Solutions by descents of one arm at a time."""

    def __init__(self, robot: Robot, group: str) -> None:
        self.joints = [robot.joint(name) for name in robot.group(group).joints]
        self._model = compile_model(robot)
        self._data = mujoco.MjData(self._model)
        self._body = self._model.body(robot.group(group).tip_link).id
        joints = [self._model.joint(joint.name) for joint in self.joints]
        self._address = [int(joint.qposadr[0]) for joint in joints]
        self._dofs = [int(joint.dofadr[0]) for joint in joints]
        for name, value in robot.initial_state.items():
            self._data.qpos[self._model.joint(name).qposadr[0]] = value
        self._lower = np.array([_limits(joint)[0] for joint in self.joints])
        self._upper = np.array([_limits(joint)[1] for joint in self.joints])

    def nearest(self, pose: Pose, here: Array, generator: np.random.Generator) -> float:
        """Return the distance of the nearest solution that is found, infinite for none."""
        best = math.inf
        low, high = np.maximum(self._lower, -math.pi), np.minimum(self._upper, math.pi)
        for number in range(_DESCENTS):
            start = here.copy() if number == 0 else generator.uniform(low, high)
            descend = self._descend(pose, start, here)
            if descend is not None:
                best = min(best, float(np.linalg.norm(descend - here)))
        return best

    def _descend(self, pose: Pose, values: Array, here: Array) -> Array | None:
        x, y, z, w = pose.orientation
        turn, place, error = np.array([w, x, y, z]), np.array(pose.position), np.zeros(6)
        inverse, between = np.zeros(4), np.zeros(4)
        jacobian = np.zeros((6, self._model.nv))
        for _ in range(_STEPS):
            self._data.qpos[self._address] = values
            mujoco.mj_kinematics(self._model, self._data)
            mujoco.mj_comPos(self._model, self._data)
            mujoco.mj_jacBody(self._model, self._data, jacobian[:3], jacobian[3:], self._body)
            error[:3] = place - self._data.xpos[self._body]
            mujoco.mju_negQuat(inverse, self._data.xquat[self._body])
            mujoco.mju_mulQuat(between, turn, inverse)
            mujoco.mju_quat2Vel(error[3:], between, 1.0)
            slope = jacobian[:, self._dofs]
            home = _turned(here - values, self.joints)
            square = slope @ slope.T + (1e-9 + 1e-2 * float(error @ error)) * np.eye(6)
            step = home + slope.T @ np.linalg.solve(square, error - slope @ home)
            longest = float(np.abs(step).max())
            if np.abs(error).max() < 1e-4 and longest < 1e-3:
                return self._within(values, here)
            values = values + step * min(1.0, 0.5 / longest)
            narrow = self._upper - self._lower < TURN - 1e-6
            values = np.where(narrow, np.clip(values, self._lower, self._upper), values)
        if np.abs(error).max() < 1e-4:
            return self._within(values, here)
        return None

    def _within(self, values: Array, here: Array) -> Array | None:
        """Return the turns within limits that are nearest to `here`."""
        within: Array = values.copy()
        for i, (value, near) in enumerate(zip(values, here, strict=True)):
            turns = [value + TURN * k for k in range(-3, 4)]
            low, high = self._lower[i] - 1e-6, self._upper[i] + 1e-6
            turns = [turn for turn in turns if low <= turn <= high]
            if not turns:
                return None
            within[i] = min(turns, key=lambda turn: abs(turn - near))
        return within


def _limits(joint: Joint) -> tuple[float, float]:
    endless = joint.type == "continuous"
    return (-math.inf, math.inf) if endless else (joint.lower, joint.upper)


def _turned(apart: Array, joints: Sequence[Joint]) -> Array:
    whole = [_limits(joint)[1] - _limits(joint)[0] >= TURN - 1e-6 for joint in joints]
    return apart - np.where(whole, TURN * np.round(apart / TURN), 0.0)


def arms() -> Iterator[tuple[str, str]]:
    """Yield robot and group of each shipped arm with a joint that turns further than once."""
    for name in robot_names():
        robot = load_robot(name)
        for group, members in sorted(robot.groups.items()):
            joints = [robot.joint(joint) for joint in members.joints]
            turning = [joint for joint in joints if joint.type != "prismatic"]
            wide = any(high - low > TURN for low, high in map(_limits, turning))
            if wide and members.tip_link and len(turning) == len(joints) >= 6:
                yield name, group
                break


def needless(joints: Sequence[Joint], before: Array, after: Array) -> int:
    """Return how many joints go a whole turn further than they need to."""
    count = 0
    for joint, here, there in zip(joints, before, after, strict=True):
        low, high = _limits(joint)
        other = there - math.copysign(TURN, there - here)
        shorter = abs(other - here) < abs(there - here) - 1e-3
        count += shorter and joint.type != "prismatic" and low <= other <= high
    return count


def _drawn(joints: Sequence[Joint], generator: np.random.Generator) -> dict[str, float]:
    limits = {
        joint.name: (max(joint.lower, -math.pi), min(joint.upper, math.pi)) for joint in joints
    }
    return {name: float(generator.uniform(*within)) for name, within in limits.items()}


def _down(yaw: float, *, along_x: bool) -> tuple[float, float, float, float]:
    """Return the orientation of a tool whose axis points down."""
    sine, cosine = math.sin(yaw / 2), math.cos(yaw / 2)
    if not along_x:
        return cosine, sine, 0.0, 0.0
    half = math.sqrt(0.5)
    return -sine * half, cosine * half, sine * half, cosine * half


def chain(name: str, group: str, goals: int) -> tuple[int, int, float, float, float]:
    """Return goals reached, needless turns, travel, travel of the nearest, and CPU time [s]."""
    robot = load_robot(name)
    kinematics, referee = Kinematics(robot), Referee(robot, group)
    generator, drawn = np.random.default_rng(5), np.random.default_rng(6)
    tip = robot.group(group).tip_link
    state = dict(robot.initial_state)
    reach = max(
        math.hypot(
            *kinematics.forward({**state, **_drawn(referee.joints, drawn)}, tip or "").position
        )
        for _ in range(40)
    )
    count, turns, travel, least, spent = 0, 0, 0.0, 0.0, 0.0
    for _ in range(8 * goals):
        if count == goals:
            break
        angle, far = drawn.uniform(-math.pi, math.pi), drawn.uniform(0.35, 0.75) * reach
        height, yaw = drawn.uniform(0.0, 0.3) * reach, drawn.uniform(-math.pi, math.pi)
        down = _down(yaw, along_x=name in _ALONG_X)
        pose = Pose((far * math.cos(angle), far * math.sin(angle), height), down)
        before = np.array([state[joint.name] for joint in referee.joints])
        begin = time.process_time()
        try:
            inverse = kinematics.inverse(group, pose, seed=state)
        except PlanningError:
            continue
        spent += time.process_time() - begin
        after = np.array([inverse[joint.name] for joint in referee.joints])
        count += 1
        turns += needless(referee.joints, before, after)
        moved = float(np.linalg.norm(after - before))
        travel += moved
        least += min(moved, referee.nearest(pose, before, generator))
        state.update(inverse)
    return count, turns, travel, least, spent


def main(arguments: Sequence[str] | None = None) -> None:
    """Follow the chains and print what was taken beside the nearest."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--robots", nargs="+", help="names of shipped robots (all)")
    parser.add_argument("--goals", type=int, default=40, help="goals of a chain")
    options = quick.parsed(parser, arguments, robots=lambda: ["ur10e"], goals=lambda: 3)
    print("| robot | goals | needless turns | travel | of the nearest | ratio | time of a goal |")
    print("|---|---|---|---|---|---|---|")
    for name, group in arms():
        if options.robots and name not in options.robots:
            continue
        count, turns, travel, least, spent = chain(name, group, options.goals)
        print(
            f"| {name} | {count} | {turns} | {travel:.1f} rad | {least:.1f} rad "
            f"| {travel / max(least, 1e-9):.3f} | {spent / max(count, 1) * 1e3:.0f} ms |",
            flush=True,
        )


if __name__ == "__main__":
    main()
