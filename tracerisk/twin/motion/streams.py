"""Follow a stream of set-points as a driver does: on a smooth way, at whatever rate it comes.

A stream samples a motion. Its set-points are joined by straight lines over the measured period of
the stream (a first-order hold), and the mean of that over a window (the driver's look-ahead, at
least one period) is the way: its speed is continuous, and its acceleration that of the motion which
was sampled. So neither the way nor the torque that it takes depends on the rate.

The set-points are due one and a half periods after they come, so that messages may come late by
half a period. Whatever is not on that way (a first set-point far from the arm, a jump, the sudden
end of a stream) is led onto it by a cubic, as fast as the limits of the joints allow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.robots.robot import Robot

Array = NDArray[np.float64]

_LATE = 1.0  # of a period: messages that are later or earlier have another rhythm
_REMEMBERED = 200  # messages through which the rhythm is the straight line
_OTHER_PERIOD = 0.25  # a period that differs by more is another one
_WHOLE = 0.05  # of a period: a look-ahead that is longer by less needs none more
_DUE = 1.5  # periods after a set-point comes
_SAME = 1e-7  # a reference nearer to the way is on it [rad or m, and per second]
_SLACK = 1.2  # of the limits: a way within it is left as it was sampled
_LEAST_S = 0.02  # of a lead-in: what is shorter is a blow


@dataclass(frozen=True, slots=True)
class _LeadIn:
    """What is left of the distance to the way, a cubic in time that ends with 0."""

    begin_s: float
    """When it begins [s]."""
    duration_s: float
    """How long it lasts [s]."""
    distance: Array
    """The distance at its begin, (n_joints,) [rad or m]."""
    rate: Array
    """How the distance changes there, (n_joints,) [rad/s or m/s]."""

    def at(self, time: Array) -> tuple[Array, Array]:
        """Return distance and its rate, (n_times, n_joints), at times [s] of (n_times,)."""
        span = self.duration_s
        u = np.clip((time - self.begin_s) / span, 0.0, 1.0)[:, None]
        rate = self.rate * span
        distance = self.distance * (1.0 + u * u * (2.0 * u - 3.0)) + rate * u * (1.0 - u) ** 2
        slope = self.distance * (6.0 * u * (u - 1.0)) + rate * (1.0 - u) * (1.0 - 3.0 * u)
        return distance, np.where(u < 1.0, slope / span, 0.0)


class SetPointStream:
    """The way of some joints along the set-points that come for them.

    Times are those of the simulation [s]; positions (n_joints,) [rad or m]. `speed` is the fraction
    of their rated speed that the driver allows, `look_ahead_s` the time over which the sender has
    it smooth them, `None` for the driver's own.
    """

    def __init__(
        self,
        robot: Robot,
        joints: Sequence[str],
        *,
        speed: float = 1.0,
        look_ahead_s: float | None = None,
    ) -> None:
        members = [robot.joint(name) for name in joints]
        self._speed_limit = np.array([joint.velocity_limit for joint in members]) * speed
        self._rise_limit = np.array([robot.followed_rise(name) for name in joints]) * speed**2
        following = robot.following
        look_ahead_s = following.look_ahead_s if look_ahead_s is None else look_ahead_s
        self._look_ahead_s = max(following.period_s, look_ahead_s)
        self._came_s = self._rhythm_s = 0.0
        self._period_s, self._heard = 0.0, 0
        self._window_s = 0.0
        self._times: list[float] = []  # when each set-point is due
        self._points: list[Array] = []
        self._lead_in: _LeadIn | None = None

    @property
    def target(self) -> Array:
        """The last set-point, (n_joints,)."""
        return self._points[-1]

    def is_over(self, time_s: float) -> bool:
        """Return whether the last set-point is reached by then."""
        return time_s >= self._end_s()

    def take(
        self,
        came_s: float,
        target: Array,
        at: tuple[Array, Array],
        now_s: float,
        due_s: float = 0.0,
    ) -> None:
        """Take a set-point that came at `came_s` and is due `due_s` later, or when it can be.

        `at` is the set-point of the servos at `now_s`, and its velocity.
        """
        gap, least_s = came_s - self._came_s, 2.0 * self._window_s
        if not self._times or gap <= 0.0 or self._is_jump(target, gap):
            self._restart(came_s, target, due_s)
            least_s = due_s
        else:
            self._go_on(gap, came_s, target, now_s, due_s)
        self._came_s = came_s
        self._join(at, now_s, least_s)

    def way(self, now_s: float, step_s: float) -> tuple[Array, Array, Array]:
        """Return times from now on, positions and velocities (n, n_joints), to rest at the end."""
        steps = max(1, math.ceil((self._end_s() - now_s) / step_s - 1e-6))
        time: Array = np.arange(1, steps + 1, dtype=np.float64) * step_s
        position, velocity = self._at(now_s + time)
        position, velocity = self._braked(now_s + time, position, velocity)
        time = np.arange(1, len(position) + 1, dtype=np.float64) * step_s
        position[-1], velocity[-1] = self._points[-1], 0.0
        return time, position, velocity

    # The set-points, and when they are due

    def _is_jump(self, target: Array, gap: float) -> bool:
        """Return whether no joint could be led on to a set-point within the time of the stream."""
        return bool((np.abs(target - self._points[-1]) > self._speed_limit * gap).any())

    def _restart(self, came_s: float, target: Array, due_s: float) -> None:
        self._rhythm_s, self._window_s = came_s, 0.0
        self._times, self._points = [came_s + due_s], [target.copy()]

    def _go_on(self, gap: float, came_s: float, target: Array, now_s: float, due_s: float) -> None:
        is_first = not self._window_s
        early = came_s - self._rhythm_s - self._period_s
        if is_first or abs(early) > _LATE * self._period_s:
            self._period_s, self._heard = gap, 1
            self._rhythm_s = came_s
        else:
            # Least squares of a line through the messages, each weighed as it comes: they are sent
            # evenly, and what delays one of them on its way is no part of the motion.
            self._heard = min(self._heard + 1, _REMEMBERED)
            n = self._heard
            self._rhythm_s += self._period_s + early * 2 * (2 * n + 1) / ((n + 1) * (n + 2))
            self._period_s += early * 6 / ((n + 1) * (n + 2))
        period = self._period_s
        # Of whole periods, over which the steps of the lines' slopes cancel.
        window = period * max(1, math.ceil(self._look_ahead_s / period - _WHOLE))
        if abs(window - self._window_s) > _OTHER_PERIOD * window:
            self._window_s = window
        # Where the last set-point was reached already, the line to this one begins now.
        if is_first:
            self._times[-1] = max(self._times[-1], self._rhythm_s + (_DUE - 1.0) * period)
        if self._times[-1] < now_s:
            self._times.append(now_s)
            self._points.append(self._points[-1])
        due = self._rhythm_s + max(_DUE * period, due_s)
        fastest = float((np.abs(target - self._points[-1]) / self._speed_limit).max())
        self._lead_on(max(due, self._times[-1] + max(fastest, 0.5 * period)), target.copy(), now_s)
        # What lies before the window counts no more.
        while len(self._times) > 2 and self._times[1] < now_s - 2.0 * self._window_s:
            del self._times[0], self._points[0]

    def _lead_on(self, due_s: float, target: Array, now_s: float) -> None:
        """Add a line to a set-point.

        Where its slope is another than the joints can change to within the window, the way is on
        that line at once, and they are led onto it.
        """
        last_s, last = self._times[-1], self._points[-1]
        slope = (target - last) / (due_s - last_s)
        before = np.zeros_like(slope)
        if len(self._times) > 1:
            before = (last - self._points[-2]) / (last_s - self._times[-2])
        if (np.abs(slope - before) > _SLACK * self._rise_limit * self._window_s).any():
            begin_s = min(now_s, last_s) - 2.0 * self._window_s
            self._times, self._points = [begin_s], [last - slope * (last_s - begin_s)]
        self._times.append(due_s)
        self._points.append(target)

    def _end_s(self) -> float:
        if not self._times:
            return 0.0
        end = self._times[-1] + self._window_s
        lead_in = self._lead_in
        return end if lead_in is None else max(end, lead_in.begin_s + lead_in.duration_s)

    # The way

    def _sampled(self, time: Array) -> tuple[Array, Array]:
        """Return the mean of the lines over the window before each time, and its rate."""
        if not self._window_s:
            still = np.repeat(self._points[-1][None, :], len(time), axis=0)
            return still, np.zeros_like(still)
        width = self._window_s
        end, end_sum = self._lines(time)
        begin, begin_sum = self._lines(time - width)
        return (end_sum - begin_sum) / width, (end - begin) / width

    def _lines(self, time: Array) -> tuple[Array, Array]:
        """Return the lines through the set-points at times, and their integral up to there."""
        due, points = np.array(self._times), np.array(self._points)
        if len(due) == 1:
            repeat = np.repeat(points, len(time), axis=0)
            return repeat, repeat * (time - due[0])[:, None]
        index = np.clip(np.searchsorted(due, time, side="right") - 1, 0, len(due) - 2)
        spans = np.diff(due)[:, None]
        slopes = np.diff(points, axis=0) / spans
        sums = np.vstack(
            (np.zeros_like(points[:1]), np.cumsum((points[1:] + points[:-1]) / 2 * spans, axis=0))
        )
        inside = np.clip(time, due[0], due[-1])
        passed = (inside - due[index])[:, None]
        repeat = points[index] + slopes[index] * passed
        summed = sums[index] + (points[index] + repeat) / 2 * passed
        # Before the first and after the last of them the joints stand.
        return repeat, summed + repeat * (time - inside)[:, None]

    def _at(self, time: Array) -> tuple[Array, Array]:
        position, velocity = self._sampled(time)
        if self._lead_in is not None:
            distance, rate = self._lead_in.at(time)
            position, velocity = position + distance, velocity + rate
        return position, velocity

    def _join(self, at: tuple[Array, Array], now_s: float, least_s: float) -> None:
        """Lead onto the way from where the set-points are, where that is elsewhere."""
        now = np.array([now_s])
        position, velocity = self._at(now)
        apart, rate = at[0] - position[0], at[1] - velocity[0]
        if (np.abs(apart) <= _SAME).all() and (np.abs(rate) <= _SAME).all():
            return
        sampled, speed = self._sampled(now)
        apart, rate = at[0] - sampled[0], at[1] - speed[0]
        span = max(self._lead_s(apart, rate), least_s)
        self._lead_in = _LeadIn(now_s, span, apart, rate)

    def _lead_s(self, apart: Array, rate: Array) -> float:
        """Return how long a cubic takes for a distance and its rate, within the limits [s].

        It speeds up hardest at its ends, by 6 d / t^2 and 4 v / t, and is fastest in its middle,
        by 1.5 d / t.
        """
        rise, far, fast = self._rise_limit, np.abs(apart), np.abs(rate)
        span = np.maximum(
            (2.0 * fast + np.sqrt(4.0 * fast**2 + 6.0 * rise * far)) / rise,
            1.5 * far / self._speed_limit,
        )
        return max(float(span.max()), _LEAST_S)

    def _braked(self, time: Array, position: Array, velocity: Array) -> tuple[Array, Array]:
        """Return the way with an end that the joints can brake to, should nothing follow."""
        last = self._times[-1]
        first = int(np.searchsorted(time, last))
        if not self._window_s or first >= len(time):
            return position, velocity
        (where,), (speed,) = self._at(np.array([last]))
        if (np.abs(speed) <= _SLACK * self._rise_limit * self._window_s).all():
            return position, velocity
        brake = _LeadIn(last, 0.0, where - self._points[-1], speed)
        span = self._lead_s(brake.distance, brake.rate)
        step = float(time[0]) if len(time) == 1 else float(time[1] - time[0])
        count = max(1, math.ceil((last + span - float(time[first])) / step))
        rest: Array = float(time[first]) + np.arange(count + 1, dtype=np.float64) * step
        distance, rate = _LeadIn(last, span, brake.distance, brake.rate).at(rest)
        return (
            np.vstack((position[:first], self._points[-1] + distance)),
            np.vstack((velocity[:first], rate)),
        )
