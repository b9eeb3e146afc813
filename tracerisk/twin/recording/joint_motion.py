"""Find when a joint moves, from how far it goes, its speed and its set-point.

A rated speed says nothing about slow motion, so none is used. The steps of a motion are those
that are fast beside the greatest speed around them, and those in which the set-point moves with
the joint; a stretch of such steps is a motion once the joint goes far enough in it. So neither
the profile of the speed nor the lag of a servo decides how long a motion lasts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Flags = NDArray[np.bool_]
Array = NDArray[np.float64]
Steps = NDArray[np.intp]
_Number = TypeVar("_Number", bound=np.number[Any])

LEVER_M = 0.1  # what an angle of 1 rad is on a sliding joint: all bounds are scaled by it [m]


@dataclass(frozen=True, slots=True)
class MotionRule:
    """When a joint moves; angles [rad], times [s]; sliding joints have `LEVER_M` a radian."""

    least_travel: float = 1e-3
    """How far a joint goes at least in a motion in which its set-point moves."""
    least_stroke: float = 5e-3
    """How far it goes at least in one direction where its set-point rests, or is not known."""
    slowest: float = 1e-3
    """The speed below which only a moving set-point makes a motion, per second."""
    least_fraction: float = 0.1
    """Of the greatest speed around: what is slower is no motion, unless the set-point moves."""
    around_s: float = 0.5
    """How far around the greatest speed is looked for, to either side."""
    set_point_step: float = 1e-9
    """A set-point that changes by no more in a step is at rest: what rounding leaves of none."""
    trembling_travel: float = 1e-4
    """A set-point that goes to and fro within so much for `trembling_s` is at rest."""
    trembling_s: float = 1.0
    """See `trembling_travel`."""
    lag: float = 0.01
    """How far a joint that follows its set-point may be from it, beside its servo's lag."""
    least_s: float = 0.02
    """What is shorter is no motion."""
    gap_s: float = 0.02
    """The longest rest that does not end a motion."""
    gap_fraction: float = 0.05
    """The longest rest that does not end a motion, of the motion before and after it."""


RULE = MotionRule()
"""That of every run."""


@dataclass(frozen=True, slots=True, eq=False)
class SetPoint:
    """The set-point of a servo beside what is measured."""

    value: Array
    """The set-point at each step [rad or m], (n_steps,)."""
    position: Array
    """The measured position at each step [rad or m], (n_steps,)."""
    lag_s: float
    """The time by which a moving joint lags behind the set-point [s]."""


def motion_steps(
    velocity: Array, set_point: SetPoint | None, unit: float, step_s: float
) -> tuple[Flags, Array]:
    """Return the steps in which a joint moves, and how far it goes in the stretch of each.

    velocity: (n_steps,) [rad/s or m/s]. `unit` scales the bounds of the rule: 1 for an angle.
    Returns two arrays (n_steps,); the second counts in the least that the rule takes for motion.
    """
    n_steps = len(velocity)
    if not n_steps:
        return np.zeros(0, dtype=np.bool_), np.zeros(0)
    way = np.cumsum(velocity) * (step_s / unit)
    strokes, travel = _strokes(velocity / unit, way, step_s)
    led = np.zeros(n_steps, dtype=np.bool_)
    if set_point is not None:
        led = _led(velocity, set_point, unit, step_s)
    moving = np.zeros(n_steps, dtype=np.bool_)
    starts, stops = _joined(*runs(strokes | led), step_s)
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        # The way before the first step belongs to it.
        part = way[max(start - 1, 0) : stop]
        least = RULE.least_travel if led[start:stop].any() else RULE.least_stroke
        far = float(part.max() - part.min()) / least
        travel[start:stop] = np.maximum(travel[start:stop], far)
        moving[start:stop] = far >= 1.0 and stop - start >= round(RULE.least_s / step_s)
    return moving, travel


def runs(flags: Flags) -> tuple[Steps, Steps]:
    """Return where the runs of true entries start, and where they stop."""
    around = np.zeros(len(flags) + 2, dtype=np.bool_)
    around[1:-1] = flags
    (edges,) = (around[1:] != around[:-1]).nonzero()
    return edges[::2], edges[1::2]


def distinct(values: NDArray[_Number]) -> NDArray[_Number]:
    """Return the different ones of some numbers, sorted.

    So does `np.unique`, which imports the masked arrays of numpy for it.
    """
    ordered = np.sort(values, axis=None)
    is_first = np.ones(len(ordered), dtype=np.bool_)
    is_first[1:] = ordered[1:] != ordered[:-1]
    return ordered[is_first]


def _strokes(velocity: Array, way: Array, step_s: float) -> tuple[Flags, Array]:
    """Return the steps of strokes, fast and in one direction, that go far enough; and how far.

    How far counts in the least that a stroke goes, at every fast step.

    A vibration is fast but goes to and fro: none of its strokes is long enough.
    """
    speed = np.abs(velocity)
    most = _most_around(speed, round(RULE.around_s / step_s))
    fast = speed > np.maximum(RULE.slowest, RULE.least_fraction * most)
    direction = np.where(fast, np.sign(velocity), 0.0)
    starts = np.concatenate(([0], np.flatnonzero(np.diff(direction)) + 1))
    lengths = np.diff(np.concatenate((starts, [len(way)])))
    far = np.abs(way[starts + lengths - 1] - way[np.maximum(starts - 1, 0)])
    travel = np.where(fast, np.repeat(far / RULE.least_stroke, lengths), 0.0)
    return travel >= 1.0, travel


def _led(velocity: Array, set_point: SetPoint, unit: float, step_s: float) -> Flags:
    """Return the steps in which the set-point moves, and the joint is where that leads it."""
    value = set_point.value
    moves = np.abs(np.diff(value, prepend=value[:1])) > RULE.set_point_step * unit
    moves &= ~_trembles(value / unit, step_s)
    behind = np.abs(value - set_point.position)
    with_it: Flags = behind <= RULE.lag * unit + set_point.lag_s * np.abs(velocity)
    return moves & with_it


def _trembles(value: Array, step_s: float) -> Flags:
    """Return the steps of any time of `trembling_s` in which a set-point goes to and fro.

    Then its way is at least three times the distance between its ends, which a turn is not.
    """
    size = round(RULE.trembling_s / step_s)
    trembles = np.zeros(len(value), dtype=np.bool_)
    windows = len(value) - size + 1
    if windows <= 0:
        return trembles
    way = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(value)))))
    way = way[size - 1 :] - way[:windows]
    # No spread is less than from the first value to the last: few windows need a closer look.
    least = np.abs(value[size - 1 :] - value[:windows])
    may_be = (way > 0.0) & (least <= RULE.trembling_travel) & (way >= 3.0 * least)
    change = np.zeros(len(value) + 1, dtype=np.int64)
    for start, stop in zip(*_wider(*runs(may_be), size), strict=True):
        part = value[start : stop + size - 1]
        spread = _windowed_most(part, size) + _windowed_most(-part, size)
        far = way[start:stop]
        is_one = (spread <= RULE.trembling_travel) & (far >= 3.0 * spread) & (far > 0.0)
        change[start:stop] += is_one
        change[start + size : stop + size] -= is_one
    trembles |= np.cumsum(change[:-1]) > 0
    return trembles


def _wider(starts: Steps, stops: Steps, least: int) -> tuple[list[int], list[int]]:
    """Return runs among which those that are less than `least` apart are one."""
    apart = starts[1:] - stops[:-1] >= least
    firsts = starts[np.concatenate(([True], apart))[: len(starts)]]
    return firsts.tolist(), stops[np.concatenate((apart, [True]))[: len(stops)]].tolist()


def _joined(starts: Steps, stops: Steps, step_s: float) -> tuple[Steps, Steps]:
    """Return runs without the rests between them that are too short to end a motion."""
    if len(starts) < 2:
        return starts, stops
    gaps = starts[1:] - stops[:-1]
    whole = stops[1:] - starts[:-1]
    short = (gaps < round(RULE.gap_s / step_s)) & (gaps <= RULE.gap_fraction * whole)
    return starts[np.concatenate(([True], ~short))], stops[np.concatenate((~short, [True]))]


def _most_around(values: Array, reach: int) -> Array:
    """Return the greatest of `values` (n,) within `reach` steps of each; values from 0 on."""
    rest = np.zeros(reach)
    return _windowed_most(np.concatenate((rest, values, rest)), 2 * reach + 1)


def _windowed_most(values: Array, size: int) -> Array:
    """Return the greatest of each `size` values in a row, (n - size + 1,).

    A window of that size reaches over the end of one block and the begin of the next (van Herk,
    Pattern Recognition Letters 13, 1992).
    """
    n_windows = len(values) - size + 1
    lacking = -len(values) % size
    blocks = np.concatenate((values, np.full(lacking, -np.inf))).reshape(-1, size)
    to_end = np.maximum.accumulate(blocks[:, ::-1], axis=1)[:, ::-1].ravel()
    from_begin = np.maximum.accumulate(blocks, axis=1).ravel()
    windowed_most: Array = np.maximum(
        to_end[:n_windows], from_begin[size - 1 : size - 1 + n_windows]
    )
    return windowed_most
