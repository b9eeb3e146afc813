"""When each sensor is in use: while its joint is, and while the controller reads it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.twin.recording.activity import ElementActivity
from tracerisk.twin.recording.exposure import longest_of_owners
from tracerisk.twin.robots.sensors import IN_JOINTS

Flags = NDArray[np.bool_]
Owners = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class ReadingSpan:
    """A time during which the controller reads some sensors."""

    sensors: tuple[str, ...]
    """The names of the sensors."""
    from_ns: int
    """The begin in simulated time [ns]."""
    to_ns: int
    """The end in simulated time [ns]."""


@dataclass(frozen=True, slots=True, eq=False)
class SensorActivity:
    """What one sensor does at each step."""

    element: Element
    """The sensor."""
    reading: Flags | None
    """Whether the controller reads it, (n_steps,); `None` where it never does."""
    joint: ElementActivity | None
    """The activity of its joint; `None` for a sensor that is in no joint."""


def sensor_activity(
    elements: Sequence[Element],
    joints: Mapping[str, ElementActivity],
    spans: Sequence[ReadingSpan],
    n_steps: int,
    step_ns: int,
) -> Mapping[str, SensorActivity]:
    """Return the activity of each sensor among the elements, by its name.

    A step is read in which a span holds at its start, and that in which one begins.
    """
    reading: dict[str, Flags] = {}
    for span in spans:
        first, last = span.from_ns // step_ns, -(-span.to_ns // step_ns)
        for name in span.sensors:
            if name not in reading:
                reading[name] = np.zeros(n_steps, dtype=np.bool_)
            reading[name][first:last] = True
    return {
        element.name: SensorActivity(
            element,
            reading.get(element.name),
            joints.get(element.part or "") if element.sensor in IN_JOINTS else None,
        )
        for element in elements
        if element.kind == "sensor"
    }


def sensor_exposures(
    activity: SensorActivity,
    of_joint: Sequence[Exposure] | None,
    owners: Owners,
    n_visits: int,
    step_s: float,
) -> list[Exposure]:
    """Return the exposure of a sensor in each visit.

    owners: (n_steps,), the index of the visit that owns each step, -1 for none. `of_joint` are
    the exposures of its joint in the visits. Moving, holding and starts are those of the joint;
    the times sum to those of the run.
    """
    like = [Exposure()] * n_visits if of_joint is None else of_joint
    joints = [
        Exposure(
            moving_s=exposure.moving_s,
            holding_s=exposure.holding_s,
            active_s=exposure.active_s,
            longest_moving_s=exposure.longest_moving_s,
            longest_active_s=exposure.longest_active_s,
            starts=exposure.starts,
            borderline=exposure.borderline,
        )
        for exposure in like
    ]
    if activity.reading is None:
        return joints
    active = (
        activity.reading if activity.joint is None else activity.reading | activity.joint.active
    )
    read_s = _seconds(activity.reading, owners, n_visits, step_s)
    active_s = _seconds(active, owners, n_visits, step_s)
    longest = longest_of_owners(active, owners, n_visits)
    return [
        replace(
            joint,
            active_s=float(active_s[index]),
            longest_active_s=longest[index] * step_s,
            reading_s=float(read_s[index]),
        )
        for index, joint in enumerate(joints)
    ]


def _seconds(flags: Flags, owners: Owners, n_visits: int, step_s: float) -> NDArray[np.float64]:
    counted = owners[flags & (owners >= 0)]
    return np.bincount(counted, minlength=n_visits).astype(np.float64) * step_s
