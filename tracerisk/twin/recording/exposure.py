"""Sum up what an element did over a set of steps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.traced.elements import WEAR_EXPONENTS, Exposure
from tracerisk.twin.recording.activity import LIMITS, ElementActivity
from tracerisk.twin.recording.joint_motion import runs

Flags = NDArray[np.bool_]
Array = NDArray[np.float64]
Steps = NDArray[np.intp]

ACTIVE_S = 0.05  # a state that lasted less does not make an element active [s]
_BORDER = 2.0  # a factor of the threshold, up or down


def exposure(activity: ElementActivity, mask: Flags, step_s: float) -> Exposure:
    """Return the exposure of an element over the steps in `mask`, see `ElementExposures`."""
    return ElementExposures(activity, step_s).over(mask)


class ElementExposures:
    """The exposures of an element; over parts of a run they take what reaches beyond these.

    What a motion or a wear is does not depend on the part, and is computed here once.
    """

    def __init__(self, activity: ElementActivity, step_s: float) -> None:
        moving, grasping = activity.moving, activity.grasping
        self.activity = activity
        self.step_s = step_s  # the physics step [s]
        self.active = activity.active  # whether it is in any of its states, (n_steps,)
        self.starts = _begins(moving)  # where a motion begins, (n_steps,)
        self.grasps = _begins(grasping)  # where a grasp begins, (n_steps,)
        # The first step after each grasp, (n_steps,).
        self.releases = _begins(~grasping) & (np.arange(len(grasping)) > 0)
        # Where it begins to move, and where it has ended to; the same of being active.
        self.moving_runs, self.active_runs = runs(moving), runs(self.active)
        # In how many steps before each it moves, (n_steps + 1,).
        self.moved_before = np.concatenate(([0], np.cumsum(moving)))
        # Speed and torque of each step in which it moves, (n_moving,).
        self.speed, self.torque = activity.speed[moving], activity.torque[moving]
        # |v| T^k of each such step, (n_moving,), for each of `WEAR_EXPONENTS`.
        self.wear = tuple(self.speed * self.torque**k for k in WEAR_EXPONENTS)

    def over(self, mask: Flags) -> Exposure:
        """Return the exposure over the steps in a mask, (n_steps,)."""
        (exposure,) = self.of_owners(np.where(mask, 0, -1), 1)
        return exposure

    def of_owners(self, owner: Steps, n_owners: int) -> tuple[Exposure, ...]:
        """Return the exposure over the steps of each owner.

        `owner` (n_steps,) has for each step one of 0 to `n_owners` - 1, or -1 for none.
        """
        exposures = [Exposure()] * n_owners
        for index, span in _spans(owner):
            exposures[index] = self._within(span, owner[span] == index)
        return tuple(exposures)

    def _within(self, span: slice, mask: Flags) -> Exposure:
        """Return the exposure over those steps of a span that are in the mask."""
        activity, step_s = self.activity, self.step_s
        moving, holding = activity.moving[span] & mask, activity.holding[span] & mask
        grasping, active = activity.grasping[span] & mask, self.active[span] & mask
        moved = slice(self.moved_before[span.start], self.moved_before[span.stop])
        is_own = mask[activity.moving[span]]
        speed, torque = self.speed[moved][is_own], self.torque[moved][is_own]
        own = runs(mask)
        longest_moving = _longest(moving, own, span.start, self.moving_runs)
        return Exposure(
            moving_s=_seconds(moving, step_s),
            holding_s=_seconds(holding, step_s),
            grasping_s=_seconds(grasping, step_s),
            active_s=_seconds(active, step_s),
            longest_moving_s=longest_moving * step_s,
            longest_active_s=_longest(active, own, span.start, self.active_runs) * step_s,
            starts=int(np.count_nonzero(self.starts[span] & mask)),
            grasps=int(np.count_nonzero(self.grasps[span] & mask)),
            torque_rms=_rms(activity.torque[span][active]),
            torque_cubic=_cubic_mean(torque, speed),
            borderline=_is_borderline(activity, span, mask, step_s, longest_moving),
            releases=int(np.count_nonzero(self.releases[span] & mask)),
            grasping_moving_s=_seconds(grasping & moving, step_s),
            travel_s=float(speed.sum()) * step_s,
            wear=tuple(float(array[moved][is_own].sum()) * step_s for array in self.wear)
            if len(speed)
            else (),
        )


def longest_of_owners(flags: Flags, owner: Steps, n_owners: int) -> list[int]:
    """Return the longest run of true entries in the steps of each owner, in steps; see `_longest`.

    `owner` is as in `ElementExposures.of_owners`.
    """
    longest, whole = [0] * n_owners, runs(flags)
    for index, span in _spans(owner):
        mask = owner[span] == index
        longest[index] = _longest(flags[span] & mask, runs(mask), span.start, whole)
    return longest


def _spans(owner: Steps) -> Iterator[tuple[int, slice]]:
    """Yield each owner, and the steps from its first to its last."""
    starts = np.flatnonzero(np.diff(owner, prepend=-2))
    stops = np.append(starts, len(owner))[1:].tolist()
    owners = owner[starts].tolist()
    firsts = dict(zip(owners[::-1], starts.tolist()[::-1], strict=True))
    behind = dict(zip(owners, stops, strict=True))
    yield from ((first, slice(firsts[first], behind[first])) for first in firsts if first >= 0)


def _seconds(flags: Flags, step_s: float) -> float:
    return int(np.count_nonzero(flags)) * step_s


def _longest(flags: Flags, own: tuple[Steps, Steps], first: int, whole: tuple[Steps, Steps]) -> int:
    """Return the length of the longest run of true entries, in steps.

    `flags` are within a mask whose runs are `own`, from the step `first` on; `whole` are the runs
    of the state in all steps. A span of the mask in which the state never fails counts with the
    whole run around it: a state that outlasts many short visits would otherwise belong to none of
    them, and how a motion is cut into visits would decide whether it is seen at all.
    """
    starts, stops = runs(flags)
    if not len(starts):
        return 0
    span = np.searchsorted(own[0], starts, side="right") - 1
    fills = (own[0][span] == starts) & (own[1][span] == stops)
    around = np.searchsorted(whole[0], starts + first, side="right") - 1
    lengths = np.where(fills, (whole[1] - whole[0])[around], stops - starts)
    return int(lengths.max(initial=0))


def _begins(flags: Flags) -> Flags:
    return flags & ~np.concatenate(([False], flags[:-1]))


def _rms(torque: Array) -> float:
    return float(np.sqrt(np.mean(torque**2))) if len(torque) else 0.0


def _cubic_mean(torque: Array, speed: Array) -> float:
    travelled = float(speed.sum())
    return float(np.cbrt((speed * torque**3).sum() / travelled)) if travelled > 0.0 else 0.0


def _is_borderline(
    activity: ElementActivity, span: slice, mask: Flags, step_s: float, longest_moving: int
) -> bool:
    """Return whether the value that decides on the element's state was near its threshold.

    `longest_moving` is how long it moved at a stretch, in steps.
    Of motion that is how far it went. Where it clearly moved, no other value decides; where it
    did not, its torque does.
    """
    n_steps = round(LIMITS.debounce_on / step_s)
    if _is_near(activity.travel[span][mask], n_steps, 1.0):
        return True
    if _is_near(activity.grip[span][mask], n_steps, LIMITS.grasping_on):
        return True
    if longest_moving * step_s >= ACTIVE_S:
        return False
    return _is_near(activity.torque[span][mask], n_steps, LIMITS.holding)


def _is_near(values: Array, n_steps: int, threshold: float) -> bool:
    """Return whether the value that was reached in `n_steps` steps is near a threshold."""
    reached = np.count_nonzero(values >= threshold / _BORDER)
    return bool(reached >= n_steps > np.count_nonzero(values > threshold * _BORDER))
