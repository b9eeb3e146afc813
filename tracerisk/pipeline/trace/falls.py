"""Which things of the scene fell or tipped in a run while nobody held them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tracerisk.pipeline.trace.recorded_run import Fall
from tracerisk.twin.recording.contacts import RunContacts
from tracerisk.twin.recording.samples import POSE_EVERY, Samples

FALL_M = 0.05
"""A thing that comes down by more, once it is let go, fell: what is set down comes lower than
that only by a few millimetres [m]."""
TIP_RAD = math.radians(45.0)
"""A thing whose axis tilts by more from where it was let go tipped over [rad]."""

Flags = NDArray[np.bool_]


def falls(samples: Samples, contacts: RunContacts | None) -> tuple[Fall, ...]:
    """Return what fell or tipped after the robot had touched or held it, in order of time.

    What the robot never touched is left out: a scene may let it settle when the run begins.
    """
    if contacts is None or not len(samples.poses):
        return ()
    names = [body.name for body in contacts.log.bodies]
    found = [
        fall
        for name, at in zip(samples.header.free_bodies, samples.header.free_at, strict=True)
        if name in names
        for fall in _falls_of(name, samples.poses[:, at : at + 7], samples, contacts)
    ]
    return tuple(sorted(found, key=lambda each: (each.time_s, each.object)))


def _falls_of(
    name: str, poses: NDArray[np.float64], samples: Samples, contacts: RunContacts
) -> Iterator[Fall]:
    held = np.zeros(len(poses), dtype=np.bool_)
    bodies = contacts.log.bodies
    first = _first_touch(name, contacts)
    for hold in contacts.holds:
        if bodies[hold.body].name == name:
            held[hold.start // POSE_EVERY : -(-hold.stop // POSE_EVERY)] = True
            first = hold.start if first is None else min(first, hold.start)
    if first is None:
        return
    height = poses[:, 2]
    # The z component of the body's own z axis, by its quaternion w, x, y, z.
    axis = 1.0 - 2.0 * (poses[:, 4] ** 2 + poses[:, 5] ** 2)
    tilt = np.arccos(np.clip(axis, -1.0, 1.0))
    begin = first // POSE_EVERY
    for start, stop in _free_spans(held, begin):
        was_held = start > 0 and bool(held[start - 1])
        # It counts from the last pose in the hand, for it falls at once.
        begun = start - 1 if was_held else start
        down = float(height[begun] - height[start:stop].min())
        turned = abs(float(tilt[stop - 1] - tilt[begun]))
        if down > FALL_M or turned > TIP_RAD:
            yield Fall(
                object=name,
                time_s=start * POSE_EVERY * samples.step_s,
                height_m=down,
                was_held=was_held,
                is_tipped=down <= FALL_M,
            )


def _first_touch(name: str, contacts: RunContacts) -> int | None:
    """Return the step in which the robot, or what it held, first touched a thing."""
    steps = [int(each.steps[0]) for each in contacts.touches if name in (each.other, each.link)]
    return min(steps, default=None)


def _free_spans(held: Flags, begin: int) -> Iterator[tuple[int, int]]:
    """Yield the spans of poses from `begin` on in which a thing is not held."""
    edges = np.flatnonzero(np.diff(np.concatenate(([True], held[begin:], [True])).astype(np.int8)))
    for start, stop in edges.reshape(-1, 2):
        yield begin + int(start), begin + int(stop)
