"""What the servos of an Interbotix arm make of commands: trajectories of the twin."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.ros.messages.dialect import nanoseconds
from tracerisk.ros.robot.motion_profiles import ramped
from tracerisk.ros.robot.trajectory_messages import slopes_at
from tracerisk.ros.vendors.interbotix.dynamixel import Servo
from tracerisk.twin.physics.motion import JointTrajectory

if TYPE_CHECKING:
    from tracerisk.twin.simulation.twin import Twin

_SET_POINT_S = 0.3
"""A command with a shorter way in time is a set-point of a stream, not a motion of its own."""


class InterbotixMotion:
    """Makes trajectories of positions and waypoints, from where the joints are."""

    def __init__(self, twin: Twin) -> None:
        self._twin = twin

    def to_positions(
        self, servos: Mapping[str, Servo], asked: Mapping[str, float]
    ) -> tuple[JointTrajectory, bool]:
        """Return the way to positions, and whether they are a set-point of a stream."""
        names = tuple(asked)
        here = self._here(names)
        goal = [self._reachable(name, asked[name]) for name in names]
        made = self._ramped(servos, names, here, goal)
        return made, made.duration_s <= _SET_POINT_S

    def through(self, servos: Mapping[str, Servo], points: Sequence[Any]) -> JointTrajectory:
        """Return the way through waypoints, each a goal that is set when its time comes.

        The driver sends a point when the one before is due, and the servo takes the time of its
        profile for it. Points further apart than that are moves from rest to rest; nearer ones
        are passed without a stop, the profile's time late.

        Raises:
            ValueError: the points are fewer than two, ill-formed or not in order.
        """
        names = tuple(servos)
        if len(points) < 2:
            raise ValueError("a trajectory has fewer than 2 points")
        for index, point in enumerate(points):
            if len(point.positions) != len(names):
                raise ValueError(
                    f"point {index} has {len(point.positions)} positions for {len(names)} joints"
                )
        times = [nanoseconds(point.time_from_start) * 1e-9 for point in points]
        if any(after <= before for before, after in pairwise(times)):
            raise ValueError("the times of the points do not rise")
        goals = [
            [
                self._reachable(name, float(position))
                for name, position in zip(names, p.positions, strict=True)
            ]
            for p in points
        ]
        sent = times[:-1]
        legs = [self._ramped(servos, names, a, b) for a, b in pairwise(goals)]
        legs[0] = self._ramped(servos, names, self._here(names), goals[1])
        gaps = [after - before for before, after in pairwise(sent)]
        if all(leg.duration_s <= gap + 1e-6 for leg, gap in zip(legs, gaps, strict=False)):
            return _joined(names, sent, legs)
        lag = max(leg.duration_s for leg in legs)
        return _passed(names, [time + lag for time in sent], self._here(names), goals[1:])

    def _here(self, names: Sequence[str]) -> list[float]:
        here = self._twin.joint_state().positions
        return [here[name] for name in names]

    def _reachable(self, name: str, value: float) -> float:
        # The servo's own limits keep it where it can go.
        joint = self._twin.robot.joint(name)
        return min(max(value, joint.lower), joint.upper)

    def _ramped(
        self,
        servos: Mapping[str, Servo],
        names: tuple[str, ...],
        start: Sequence[float],
        goal: Sequence[float],
    ) -> JointTrajectory:
        ramps = []
        for name, a, b in zip(names, start, goal, strict=True):
            joint = self._twin.robot.joint(name)
            way = abs(b - a)
            ramps.append(servos[name].ramp(way, joint.velocity_limit, joint.acceleration_limit))
        return ramped(names, start, goal, ramps)


def _joined(
    names: tuple[str, ...], sent: Sequence[float], legs: Sequence[JointTrajectory]
) -> JointTrajectory:
    time: list[float] = []
    position: list[Any] = []
    velocity: list[Any] = []
    for begin, leg in zip(sent, legs, strict=True):
        if time and begin > time[-1] + 1e-6:
            # It rests where it is until the next goal is set.
            time.append(begin)
            position.append(position[-1])
            velocity.append(np.zeros(len(names)))
        time += [begin + item for item in leg.time]
        position += list(leg.position)
        velocity += list(leg.velocity)
    kept = [i for i, value in enumerate(time) if i == 0 or value > time[i - 1] + 1e-9]
    return JointTrajectory(
        names,
        np.array([time[i] for i in kept]),
        np.array([position[i] for i in kept]),
        np.array([velocity[i] for i in kept]),
    )


def _passed(
    names: tuple[str, ...],
    time: Sequence[float],
    start: Sequence[float],
    goals: Sequence[Sequence[float]],
) -> JointTrajectory:
    times, positions = np.array(time), np.array(goals)
    return JointTrajectory(names, times, positions, slopes_at(times, positions, np.array(start)))
