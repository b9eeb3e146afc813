"""Sum up what an element did over a set of steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tracerisk.trace import WEAR_EXPONENTS, Exposure
from tracerisk.twin.recording.activity import ElementActivity
from tracerisk.twin.recording.joint_motion import runs

Flags = NDArray[np.bool_]
Array = NDArray[np.float64]
Steps = NDArray[np.intp]

ACTIVE_S = 0.05  # a state that lasted less does not make an element active [s]
_BORDER = 2.0  # a factor of the threshold, up or down


def exposure(activity: ElementActivity, mask: Flags, step_s: float) -> Exposure:
    """Return the exposure of an element over the steps in `mask`, (n_steps,).

    Over masks that split the run, times, travel, wear, starts, grasps and releases sum to those
    of the whole run; a release belongs to the first step in which nothing is grasped any more.
    torque_rms is over the active steps. torque_cubic is (sum |v| T^3 / sum |v|)^(1/3) over the
    moving steps: the load at which a drive that wears by revolutions would age alike.
    """
    if not mask.any():
        return Exposure()
    activity, mask = _around(activity, mask)
    spans = runs(mask)
    longest_moving = _longest(activity.moving, mask, spans)
    moving, holding = activity.moving & mask, activity.holding & mask
    grasping, active = activity.grasping & mask, activity.active & mask
    speed, torque = activity.speed[moving], activity.torque[moving]
    return Exposure(
        moving_s=_seconds(moving, step_s),
        holding_s=_seconds(holding, step_s),
        grasping_s=_seconds(grasping, step_s),
        active_s=_seconds(active, step_s),
        longest_moving_s=longest_moving * step_s,
        longest_active_s=_longest(activity.active, mask, spans) * step_s,
        starts=int(np.count_nonzero(_begins(activity.moving) & mask)),
        grasps=int(np.count_nonzero(_begins(activity.grasping) & mask)),
        torque_rms=_rms(activity.torque[active]),
        torque_cubic=_cubic_mean(torque, speed),
        borderline=_is_borderline(activity, mask, step_s, longest_moving),
        releases=int(np.count_nonzero(_ends(activity.grasping) & mask)),
        grasping_moving_s=_seconds(grasping & moving, step_s),
        travel_s=float(speed.sum()) * step_s,
        wear=_wear(torque, speed, step_s) if moving.any() else (),
    )


def _around(activity: ElementActivity, mask: Flags) -> tuple[ElementActivity, Flags]:
    """Return both from the last step before the mask in which the element rests to the next after.

    No state reaches further: what is computed of the mask is the same, and a visit costs no more
    than its own length. The mask is not empty.
    """
    first, behind = _first(mask), _last(mask) + 1
    rests = ~activity.active
    before, after = _last(rests[:first]), behind + _first(rests[behind:])
    span = slice(max(before, 0), min(after + 1, len(mask)))
    names = ("moving", "holding", "grasping", "speed", "torque", "grip", "travel")
    return replace(activity, **{name: getattr(activity, name)[span] for name in names}), mask[span]


def _first(flags: Flags) -> int:
    """Return where the first true entry is; the length where there is none."""
    at = int(flags.argmax()) if len(flags) else 0
    return at if at < len(flags) and flags[at] else len(flags)


def _last(flags: Flags) -> int:
    """Return where the last true entry is; -1 where there is none."""
    # From behind NumPy looks through a copy of the array.
    return flags.tobytes().rfind(b"\x01")


def _seconds(flags: Flags, step_s: float) -> float:
    return int(np.count_nonzero(flags)) * step_s


def _longest(flags: Flags, mask: Flags, spans: tuple[Steps, Steps]) -> int:
    """Return the length of the longest run of true entries within `mask`, in steps.

    `spans` are where the runs of the mask start and stop.
    A span of the mask in which `flags` never fails counts with the whole run around it: a state
    that outlasts many short visits would otherwise belong to none of them, and how a motion is
    cut into visits would decide whether it is seen at all.
    """
    starts, stops = runs(flags & mask)
    if not len(starts):
        return 0
    span = np.searchsorted(spans[0], starts, side="right") - 1
    fills = (spans[0][span] == starts) & (spans[1][span] == stops)
    whole_starts, whole_stops = runs(flags)
    around = np.searchsorted(whole_starts, starts, side="right") - 1
    lengths = np.where(fills, (whole_stops - whole_starts)[around], stops - starts)
    return int(lengths.max(initial=0))


def _begins(flags: Flags) -> Flags:
    return flags & ~np.concatenate(([False], flags[:-1]))


def _ends(flags: Flags) -> Flags:
    return ~flags & np.concatenate(([False], flags[:-1]))


def _wear(torque: Array, speed: Array, step_s: float) -> tuple[float, ...]:
    """Return the integral of |v| T^k over the steps given, for each of `WEAR_EXPONENTS` [s]."""
    return tuple(float((speed * torque**k).sum()) * step_s for k in WEAR_EXPONENTS)


def _rms(torque: Array) -> float:
    return float(np.sqrt(np.mean(torque**2))) if len(torque) else 0.0


def _cubic_mean(torque: Array, speed: Array) -> float:
    travelled = float(speed.sum())
    return float(np.cbrt((speed * torque**3).sum() / travelled)) if travelled > 0.0 else 0.0


def _is_borderline(
    activity: ElementActivity, mask: Flags, step_s: float, longest_moving: int
) -> bool:
    """Return whether the value that decides on the element's state was near its threshold.

    `longest_moving` is how long it moved at a stretch, in steps.
    Of motion that is how far it went. Where it clearly moved, no other value decides; where it
    did not, its torque does.
    """
    limits = activity.thresholds
    n_steps = round(limits.debounce_on / step_s)
    if _is_near(activity.travel[mask], n_steps, 1.0):
        return True
    if _is_near(activity.grip[mask], n_steps, limits.grasping_on):
        return True
    if longest_moving * step_s >= ACTIVE_S:
        return False
    return _is_near(activity.torque[mask], n_steps, limits.holding)


def _is_near(values: Array, n_steps: int, threshold: float) -> bool:
    """Return whether the value that was reached in `n_steps` steps is near a threshold."""
    reached = np.count_nonzero(values >= threshold / _BORDER)
    return bool(reached >= n_steps > np.count_nonzero(values > threshold * _BORDER))
