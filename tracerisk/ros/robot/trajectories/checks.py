"""What a controller of joint trajectories refuses, and with which words and code."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.messages.dialect import nanoseconds
from tracerisk.ros.robot.trajectories.settings import TrajectorySettings
from tracerisk.ros.robot.trajectory_messages import TrajectoryCode, TrajectoryRefusedError
from tracerisk.ros.time.clock import EPOCH_NS

END_VELOCITY = "trajectory-end-velocity"
EFFORT = "trajectory-effort"
PAST_POINTS = "trajectory-past-points"
LENGTHS = "trajectory-lengths"

_MOVING = float(np.finfo(np.float32).eps)  # of a velocity that counts as one [rad/s or m/s]
_S = 1e-9
_FIELDS = ("positions", "velocities", "accelerations", "effort")


@dataclass(frozen=True, slots=True)
class Asked:
    """A trajectory as it was sent, and whom it was sent to."""

    message: Any
    """The trajectory_msgs/JointTrajectory of either ROS."""
    settings: TrajectorySettings
    """The parameters of the controller."""
    missing: tuple[str, ...]
    """Joints of the controller that the message does not name."""
    foreign: tuple[str, ...]
    """Names in the message that are no joints of the controller."""
    rules: DistroRules
    """The rules of the run's distribution."""
    now_ns: int
    """The time at which it arrives, since the start of the run [ns]."""

    @property
    def names(self) -> tuple[str, ...]:
        """The joints that it names."""
        return tuple(self.message.joint_names)

    @property
    def points(self) -> Sequence[Any]:
        """Its points."""
        return tuple(self.message.points)

    def times_s(self) -> list[float]:
        """Return when each point is to be reached, from now on [s]."""
        stamp_ns = nanoseconds(self.message.header.stamp)
        start_s = (stamp_ns - EPOCH_NS - self.now_ns) * _S if stamp_ns else 0.0
        return [start_s + nanoseconds(point.time_from_start) * _S for point in self.points]


def check(asked: Asked) -> None:
    """Raise TrajectoryRefusedError for the first reason to refuse a trajectory with points."""
    for find in (_joints, _end_velocity, _rising, _past, _lengths, _effort, _numbers):
        for words, code in find(asked):
            raise TrajectoryRefusedError(words, code, is_late=find is _past)


def check_joints(asked: Asked) -> None:
    """Raise TrajectoryRefusedError where the joints alone are a reason to refuse."""
    for words, code in _joints(asked):
        raise TrajectoryRefusedError(words, code)


Reasons = Iterator[tuple[str, TrajectoryCode]]


def _joints(asked: Asked) -> Reasons:
    code = TrajectoryCode.INVALID_JOINTS
    if not asked.names:
        yield "the trajectory has no joints", code
    if asked.foreign:
        yield (
            f"'{asked.foreign[0]}' is no joint of its controller, which has "
            f"{', '.join(asked.settings.joints)}",
            code,
        )
    # Names are only counted: one that comes twice stands for another.
    own = asked.settings.joints
    if own and len(asked.names) > len(own) and not asked.settings.takes_part_of_joints:
        yield f"it names {len(asked.names)} joints, and its controller has {len(own)}", code
    is_short = len(asked.names) != len(own)
    if asked.missing and is_short and not asked.settings.takes_part_of_joints:
        yield (
            f"it names {len(asked.names)} of the {len(own)} joints of its "
            f"controller, without {', '.join(asked.missing)}; name them all, or let the controller "
            "have allow_partial_joints_goal: true",
            code,
        )


def _end_velocity(asked: Asked) -> Reasons:
    speeds = [float(value) for value in asked.points[-1].velocities]
    moving = [at for at, speed in enumerate(speeds) if abs(speed) > _MOVING]
    if not moving:
        return
    allowed, rule = asked.settings.ends_moving, asked.rules.value(END_VELOCITY)
    if allowed or rule == "always followed" or (allowed is None and rule == "followed"):
        return
    name = asked.names[moving[0]] if moving[0] < len(asked.names) else str(moving[0])
    yield (
        f"the last point has a velocity of {speeds[moving[0]]:g} for joint '{name}'; let it end "
        "with 0, or let the controller have allow_nonzero_velocity_at_trajectory_end: true",
        TrajectoryCode.INVALID_GOAL,
    )


def rests_on_end_velocity(asked: Asked) -> bool:
    """Return whether the distribution's rule of end velocities decides about a trajectory."""
    speeds = asked.points[-1].velocities if asked.points else ()
    return asked.settings.ends_moving is None and any(abs(float(v)) > _MOVING for v in speeds)


def _rising(asked: Asked) -> Reasons:
    times = [nanoseconds(point.time_from_start) * _S for point in asked.points]
    if any(later <= earlier for earlier, later in pairwise(times)):
        yield (
            "the times of the points do not rise strictly: "
            + ", ".join(f"{time:g}" for time in times[:6]),
            TrajectoryCode.INVALID_GOAL,
        )


def _past(asked: Asked) -> Reasons:
    if asked.rules.value(PAST_POINTS) == "dropped" or not nanoseconds(asked.message.header.stamp):
        return
    last_s = asked.times_s()[-1]
    if last_s < 0.0:
        yield (
            f"all points lie in the past, the last by {-last_s:.3f} s",
            TrajectoryCode.OLD_HEADER_TIMESTAMP,
        )


def _lengths(asked: Asked) -> Reasons:
    yield from _LENGTH_RULES[str(asked.rules.value(LENGTHS))](asked)


def _of_names(asked: Asked) -> Reasons:
    """Find points without a value for each name."""
    count, code = len(asked.names), TrajectoryCode.INVALID_GOAL
    for index, point in enumerate(asked.points):
        given = {name: len(getattr(point, name)) for name in _FIELDS[:3]}
        if asked.settings.integrates and not any(given.values()):
            yield f"point {index} has neither positions nor velocities nor accelerations", code
        for name, length in given.items():
            may_lack = asked.settings.integrates or name != "positions"
            if length != count and not (may_lack and length == 0):
                yield f"point {index} has {length} {name} for {count} joints", code


def _of_positions(asked: Asked) -> Reasons:
    """Find points without positions, or whose other fields have another length."""
    code = TrajectoryCode.INVALID_GOAL
    for index, point in enumerate(asked.points):
        count = len(point.positions)
        # More positions than names are not looked at; fewer would be read past their end.
        if count < len(asked.names):
            yield f"point {index} has {count} positions for {len(asked.names)} joints", code
        for name in _FIELDS[1:3]:
            length = len(getattr(point, name))
            if length not in (0, count):
                yield f"point {index} has {length} {name} for {count} positions", code


_LENGTH_RULES: dict[str, Callable[[Asked], Reasons]] = {
    "one value a joint": _of_names,
    "one value a position": _of_positions,
}


def _effort(asked: Asked) -> Reasons:
    rule = asked.rules.value(EFFORT)
    if rule == "ignored" or (asked.settings.takes_effort and rule != "refused"):
        return
    for index, point in enumerate(asked.points):
        if len(point.effort):
            yield (
                f"point {index} has effort, which a controller without an effort interface does "
                "not take; leave effort empty",
                TrajectoryCode.INVALID_GOAL,
            )


def _numbers(asked: Asked) -> Reasons:
    for point in asked.points:
        for name in _FIELDS[:3]:
            if not all(math.isfinite(float(value)) for value in getattr(point, name)):
                yield (
                    "the trajectory holds a number that is not finite",
                    TrajectoryCode.INVALID_GOAL,
                )
