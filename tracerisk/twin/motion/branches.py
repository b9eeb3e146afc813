"""Find the branches of the inverse kinematics: many descents at once, from all over the range.

Each descent takes steps of Levenberg and Marquardt towards the targets, and, of the positions
that an arm with spare joints has there, goes to that nearest to where the joints are. What they
come to are starts for an exact search, not yet solutions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.motion.descent import TURN_COST
from tracerisk.twin.physics.motion import LinkTarget

import mujoco  # isort: skip

Array = NDArray[np.float64]

_DESCENTS = 64
_STEPS = 30
_LONGEST = 0.8  # of one step, in the joint that moves most [rad or m]
_ANY_TURN, _ANYWHERE = math.pi, 10.0  # tolerances that everything meets [rad], [m]
_DAMPING = 1e-2  # of the squared miss: small steps far away, quadratic convergence near by
_LEAST_DAMPING = 1e-10
_THERE = 1e-3  # the miss of a descent that has arrived [m, or rad times its cost]
_STILL = 2e-3  # the last step of one that has come to rest [rad or m]
_APART = 0.02  # two branches differ more than this in a joint [rad or m]
_DIGITS = 5  # of a start, so that processors which differ in the last bit give the same


class _Chain:
    """The way from the world to a link: fixed frames, and the joints that are free to move."""

    def __init__(self, model: Any, data: Any, target: LinkTarget, columns: Sequence[int]) -> None:
        self.segments: list[tuple[Array, Array, int, bool, Array]] = []
        """Frame before a free joint (turn, place), its column, whether it slides, its axis."""
        bodies, body = [], int(model.body(target.link).id)
        while body:
            bodies.append(body)
            body = int(model.body_parentid[body])
        turn, place = np.eye(3), np.zeros(3)
        for body in reversed(bodies):
            place = place + turn @ model.body_pos[body]
            turn = turn @ _matrix(model.body_quat[body])
            begin = int(model.body_jntadr[body])
            for joint in range(begin, begin + int(model.body_jntnum[body])):
                axis = np.array(model.jnt_axis[joint])
                slides = int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
                address = int(model.jnt_qposadr[joint])
                if address in columns:
                    self.segments.append((turn, place, columns.index(address), slides, axis))
                    turn, place = np.eye(3), np.zeros(3)
                elif slides:
                    place = place + turn @ axis * float(data.qpos[address])
                else:
                    turn = turn @ _about(axis, np.array([float(data.qpos[address])]))[0]
        self.end = (turn, place)
        quaternion = np.array([target.pose.orientation[i] for i in (3, 0, 1, 2)])
        self._turn = _matrix(quaternion / float(np.linalg.norm(quaternion)))
        self._place = np.array(target.pose.position)
        self.rows = [
            *([0, 1, 2] if target.position_tolerance < _ANYWHERE else []),
            *([3, 4, 5] if target.orientation_tolerance < _ANY_TURN else []),
        ]

    def miss(self, values: Array) -> tuple[Array, Array]:
        """Return the miss of the target and its slope; values: (n, n_joints).

        Returns (n, n_rows) and (n, n_rows, n_joints); turns are times their cost.
        """
        count = len(values)
        turn, place = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3))
        axes, anchors = [], []
        for before, shift, column, slides, axis in self.segments:
            place = place + turn @ shift
            turn = turn @ before
            along = turn @ axis
            axes.append(along)
            anchors.append(place)
            if slides:
                place = place + along * values[:, column, None]
            else:
                turn = turn @ _about(axis, values[:, column])
        place = place + turn @ self.end[1]
        turn = turn @ self.end[0]
        slope = np.zeros((count, 6, values.shape[1]))
        for (_, _, column, slides, _), along, anchor in zip(
            self.segments, axes, anchors, strict=True
        ):
            if slides:
                slope[:, :3, column] = along
            else:
                slope[:, :3, column] = np.cross(along, place - anchor)
                slope[:, 3:, column] = along * TURN_COST
        miss = np.concatenate(
            (self._place - place, TURN_COST * _turned(self._turn @ turn.transpose(0, 2, 1))),
            axis=1,
        )
        return miss[:, self.rows], slope[:, self.rows]


def branches(
    model: Any,
    data: Any,
    targets: Sequence[LinkTarget],
    columns: Sequence[int],
    lower: Array,
    upper: Array,
) -> Array:
    """Return positions of the joints at `columns` that bring links to targets, (n, n_joints).

    model, data: of MuJoCo, `data.qpos` with where the joints are. lower, upper: (n_joints,),
    limits, infinite for a joint that a whole turn brings back within them.
    """
    near = np.array(data.qpos[columns])
    chains = [_Chain(model, data, target, columns) for target in targets]
    generator = np.random.default_rng(0)
    drawn_from = (
        np.where(np.isfinite(lower), lower, -np.pi),
        np.where(np.isfinite(upper), upper, np.pi),
    )
    values = generator.uniform(*drawn_from, (_DESCENTS, len(near)))
    values[0] = np.clip(near, lower, upper)
    turns = ~np.isfinite(lower)
    # The nearest are wanted first; of the others, some that are no nearest ones.
    pull = np.where(np.arange(_DESCENTS) % 4 == 3, 0.0, 1.0)
    arrays: list[Array] = []
    for _ in range(_STEPS):
        parts = [chain.miss(values) for chain in chains]
        miss = np.concatenate([part[0] for part in parts], axis=1)
        slope = np.concatenate([part[1] for part in parts], axis=1)
        home = near - values
        home -= np.where(turns, 2 * np.pi * np.round(home / (2 * np.pi)), 0.0)
        home *= pull[:, None]
        step = _step(miss, slope, home, values, lower, upper)
        size = np.abs(step).max(axis=1)
        far = np.sqrt(np.square(miss).sum(axis=1))
        is_there = (far < _THERE) & (size < _STILL)
        arrays.extend(values[is_there] + step[is_there])
        step *= np.minimum(1.0, _LONGEST / np.maximum(size, 1e-12))[:, None]
        values = np.clip(values + step, lower, upper)[~is_there]
        pull = pull[~is_there]
        if not len(values):
            break
    return _distinct(np.array(arrays).reshape(-1, len(near)), turns)


def _step(
    miss: Array, slope: Array, home: Array, values: Array, lower: Array, upper: Array
) -> Array:
    """Return the steps that meet the targets and else lead home, for joints not at a limit."""
    downhill = (slope * miss[:, :, None]).sum(axis=1) + home
    held = ((values <= lower) & (downhill < 0.0)) | ((values >= upper) & (downhill > 0.0))
    slope = np.where(held[:, None, :], 0.0, slope)
    home = np.where(held, 0.0, home)
    square = slope @ slope.transpose(0, 2, 1)
    damping = _DAMPING * np.square(miss).sum(axis=1) + _LEAST_DAMPING
    rows = np.arange(square.shape[1])
    square[:, rows, rows] += damping[:, None]
    rest = miss - (slope @ home[:, :, None])[:, :, 0]
    weights = np.linalg.solve(square, rest[:, :, None])
    step: Array = home + (slope.transpose(0, 2, 1) @ weights)[:, :, 0]
    return step


def _distinct(found: Array, turns: NDArray[np.bool_]) -> Array:
    kept: list[Array] = []
    for values in found:
        for other in kept:
            apart = values - other
            apart -= np.where(turns, 2 * np.pi * np.round(apart / (2 * np.pi)), 0.0)
            if float(np.abs(apart).max()) < _APART:
                break
        else:
            kept.append(values)
    return np.round(np.array(kept).reshape(-1, found.shape[1]), _DIGITS)


def _matrix(quaternion: Array) -> Array:
    flat = np.zeros(9)
    mujoco.mju_quat2Mat(flat, np.asarray(quaternion, dtype=np.float64))
    return flat.reshape(3, 3)


def _about(axis: Array, angles: Array) -> Array:
    """Return the turns by angles (n,) about an axis, (n, 3, 3); O. Rodrigues's formula."""
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    turned: Array = np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross)
    return turned


def _turned(turns: Array) -> Array:
    """Return the rotation vectors of turns (n, 3, 3), (n, 3) [rad]."""
    twice = np.stack(
        (
            turns[:, 2, 1] - turns[:, 1, 2],
            turns[:, 0, 2] - turns[:, 2, 0],
            turns[:, 1, 0] - turns[:, 0, 1],
        ),
        axis=1,
    )
    sine = np.sqrt(np.square(twice).sum(axis=1)) / 2
    cosine = (np.trace(turns, axis1=1, axis2=2) - 1.0) / 2
    angle = np.arctan2(sine, cosine)
    vector: Array = twice / 2 * (angle / np.maximum(sine, 1e-12))[:, None]
    return vector
