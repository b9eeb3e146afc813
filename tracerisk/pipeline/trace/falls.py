"""Which things of the scene fell, tipped, or slipped out of a hand in a run."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tracerisk.pipeline.trace.recorded_run import FALL_M, Fall
from tracerisk.twin.recording.contacts import RunContacts
from tracerisk.twin.recording.samples import POSE_EVERY, Samples
from tracerisk.twin.recording.slips import Slips

TIP_RAD = math.radians(45.0)
"""A thing whose axis tilts by more than its hand turned it tipped over [rad]."""

_BEGUN_RAD = math.radians(5.0)  # a thing whose axis turned by more has begun to tip [rad]

Flags = NDArray[np.bool_]


def falls(samples: Samples, contacts: RunContacts | None) -> tuple[Fall, ...]:
    """Return what fell, tipped or slipped after the robot had touched or held it, in order of time.

    What the robot never touched is left out: a scene may let it settle when the run begins.
    """
    if contacts is None or not len(samples.poses):
        return ()
    names = [body.name for body in contacts.log.bodies]
    slips = Slips(samples, contacts)
    result = [
        fall
        for name, at in zip(samples.header.free_bodies, samples.header.free_at, strict=True)
        if name in names
        for fall in _falls_of(name, samples.poses[:, at : at + 7], slips)
    ]
    return tuple(sorted(result, key=lambda item: (item.time_s, item.object)))


def _falls_of(name: str, poses: NDArray[np.float64], slips: Slips) -> Iterator[Fall]:
    samples, contacts = slips.samples, slips.contacts
    held = np.zeros(len(poses), dtype=np.bool_)
    own = [item for item in contacts.holds if contacts.log.bodies[item.body].name == name]
    for hold in own:
        held[hold.start // POSE_EVERY : -(-hold.stop // POSE_EVERY)] = True
    touched = [hold.start for hold in own]
    if (first := _first_touch(name, contacts)) is not None:
        touched.append(first)
    if not touched:
        return
    height = poses[:, 2]
    # Where the body's own z axis points, by its quaternion w, x, y, z.
    w, x, y, z = poses[:, 3:].T
    axis = np.stack((2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x**2 + y**2)), axis=1)
    for start, stop in _free_spans(held, min(touched) // POSE_EVERY):
        was_held = start > 0 and bool(held[start - 1])
        # It counts from the last pose in the hand, for it falls at once.
        begun = start - 1 if was_held else start
        ended = [item for item in own if item.start // POSE_EVERY <= begun] if was_held else []
        slipped = bool(ended) and slips.has_slipped(ended[-1], poses)
        down = float(height[begun] - height[start:stop].min())
        stood = axis[begun]
        if ended:
            # A hand that turns what it holds lays it down on purpose.
            stood = slips.turn_between(ended[-1]) @ axis[ended[-1].start // POSE_EVERY]
        turned = abs(_tilt(axis[stop - 1]) - _tilt(stood))
        is_tipped = turned > TIP_RAD and name not in samples.header.balls
        if down > FALL_M or is_tipped or slipped:
            yield Fall(
                object=name,
                time_s=start * POSE_EVERY * samples.step_s,
                height_m=down,
                was_held=was_held,
                is_tipped=is_tipped,
                upright_m=down_upright(height[begun:stop], axis[begun:stop]) if is_tipped else None,
                slipped_from=ended[-1].holder if slipped else "",
            )


def down_upright(height: NDArray[np.float64], axis: NDArray[np.float64]) -> float:
    """Return how far a thing came down before its axis turned [m]: the height that it fell from.

    `height` (n_poses,) [m] and `axis` (n_poses, 3) begin with the pose in which it was let go.
    """
    turned = axis @ axis[0] < math.cos(_BEGUN_RAD)
    until = int(np.argmax(turned)) if turned.any() else len(height)
    return float(height[0] - height[:until].min())


def _tilt(axis: NDArray[np.float64]) -> float:
    """Return the angle between an axis and the vertical [rad]."""
    return math.acos(min(max(float(axis[2]), -1.0), 1.0))


def _first_touch(name: str, contacts: RunContacts) -> int | None:
    """Return the step in which the robot, or what it held, first touched a thing."""
    steps = [int(touch.steps[0]) for touch in contacts.touches if name in (touch.other, touch.link)]
    return min(steps, default=None)


def _free_spans(held: Flags, begin: int) -> Iterator[tuple[int, int]]:
    """Yield the spans of poses from `begin` on in which a thing is not held."""
    edges = np.flatnonzero(np.diff(np.concatenate(([True], held[begin:], [True])).astype(np.int8)))
    for start, stop in edges.reshape(-1, 2):
        yield begin + int(start), begin + int(stop)


def how_it_fell(fall: Fall) -> tuple[str, str]:
    """Return the code of a reason, and its words."""
    fell = f"fell {1000.0 * fall.height_m:.0f} mm" if fall.height_m > FALL_M else ""
    if fell and fall.upright_m is not None:
        # What tips comes down by its own height, too; what is below it is missing by the rest.
        fell += f" (its middle; {1000.0 * fall.upright_m:.0f} mm before it began to tip)"
    done = " and ".join(filter(None, (fell, "tipped over" if fall.is_tipped else "")))
    if fall.slipped_from:
        slipped = f"slipped out of {fall.slipped_from}, which was not opened"
        return "object-slipped", ", and ".join(filter(None, (slipped, done)))
    how = "after it was let go" if fall.was_held else "after the robot touched it"
    code = "object-tipped"
    if fell:
        code = "object-dropped" if fall.was_held else "object-knocked"
    return code, f"{done} {how}"
