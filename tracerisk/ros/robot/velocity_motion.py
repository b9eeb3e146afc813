"""What joints do that are commanded velocities: they go on until the next command."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tracerisk.twin.physics.motion import JointTrajectory

if TYPE_CHECKING:
    from tracerisk.twin.simulation.twin import Twin

_RISE_S = 0.02
_LONGEST_S = 1000.0
_SAME = 0.005  # of the rated velocity: no other command
_OFTEN_S = 0.05  # the same command is renewed no more often


def at_velocities(
    twin: Twin,
    asked: Mapping[str, float],
    for_s: float | None = None,
    start: Mapping[str, float] | None = None,
) -> JointTrajectory | None:
    """Return the way of joints at velocities [rad/s], None where they are at rest.

    It begins at `start`, by default where they are.

    It ends when the first of them is at its limit, or after `for_s` where that is less: they come
    to rest then, as those of a driver that hears no more commands.
    """
    names = tuple(asked)
    joints = [twin.robot.joint(name) for name in names]
    at = {**twin.joint_state().positions, **(start or {})}
    here = np.array([at[name] for name in names])
    speed = np.array(
        [
            float(np.clip(asked[joint.name], -joint.velocity_limit, joint.velocity_limit))
            for joint in joints
        ]
    )
    left = [
        ((joint.upper if v > 0 else joint.lower) - x) / v
        for joint, x, v in zip(joints, here, speed, strict=True)
        if abs(v) > 1e-6
    ]
    if not left:
        return None
    time = min(min(left), _LONGEST_S if for_s is None else for_s)
    if time <= 2 * _RISE_S:
        return None
    times = np.array([_RISE_S, time - _RISE_S, time])
    ways = (_RISE_S / 2, time - 1.5 * _RISE_S, time - _RISE_S)
    return JointTrajectory(
        names,
        times,
        np.vstack([here + speed * way for way in ways]),
        np.vstack((speed, speed, np.zeros(len(names)))),
    )


class VelocityStream:
    """Velocities that come again and again: each goes on from where the one before has led."""

    def __init__(self, twin: Twin) -> None:
        self._twin = twin
        self._last: dict[tuple[str, ...], tuple[int, dict[str, float], dict[str, float]]] = {}

    def next(self, asked: Mapping[str, float], now_ns: int, for_s: float) -> JointTrajectory | None:
        """Return the way of joints at velocities, which ends after `for_s` without another.

        None where they are at rest, or go on as they do. Who was at rest begins where the joints
        are: something else may have moved them.
        """
        names = tuple(asked)
        known = self._last.get(names)
        if not any(asked.values()):
            self._last.pop(names, None)
            return None
        if known is not None and now_ns - known[0] < min(_OFTEN_S, for_s / 4) * 1e9:
            rated = {name: self._twin.robot.joint(name).velocity_limit for name in names}
            if all(abs(asked[n] - known[2][n]) < _SAME * rated[n] for n in names):
                return None
        start: dict[str, float] = {}
        if known is not None and 0 < now_ns - known[0] <= for_s * 1e9:
            passed = (now_ns - known[0]) * 1e-9
            for name in names:
                joint = self._twin.robot.joint(name)
                led = known[1][name] + passed * known[2][name]
                start[name] = min(max(led, joint.lower), joint.upper)
        else:
            at = self._twin.joint_state().positions
            start = {name: at[name] for name in names}
        self._last[names] = (now_ns, start, dict(asked))
        return at_velocities(self._twin, asked, for_s, start)
