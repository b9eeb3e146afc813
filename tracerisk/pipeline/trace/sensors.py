"""The sensors of a run: which there are with what its scenario adds, and what was read of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.ros.graph.sensor_reading import CHANNEL, SPAN
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.sensor_topics import scenario_elements
from tracerisk.trace import Visit
from tracerisk.twin.recording.sensor_activity import ReadingSpan, sensor_activity, sensor_exposures

if TYPE_CHECKING:
    from tracerisk.config import Settings
    from tracerisk.instrument.ownership import Attribution
    from tracerisk.instrument.recording import Recording
    from tracerisk.twin.recording.activity import ElementActivity
    from tracerisk.twin.recording.samples import Samples
    from tracerisk.twin.robots.robot import Robot


def elements_of(robot: Robot, settings: Settings) -> tuple[Element, ...]:
    """Return what a run watches: the robot's elements, then the sensors of its scenario."""
    if settings.scenario is None:
        return robot.elements
    return (*robot.elements, *scenario_elements(robot, read_scenario(Path(settings.scenario))))


def reading_spans(recording: Recording, end_ns: int) -> tuple[ReadingSpan, ...]:
    """Return the spans in which sensors were read; one that never ended ends with the run."""
    sensors: dict[int, tuple[str, ...]] = {}
    ends: dict[tuple[int, int], int] = {}
    for note in recording.notes:
        if note.kind == CHANNEL:
            sensors[note.data["channel"]] = tuple(note.data["sensors"])
        elif note.kind == SPAN:
            to_ns = note.data["to_ns"]
            ends[note.data["channel"], note.data["from_ns"]] = end_ns if to_ns is None else to_ns
    return tuple(
        ReadingSpan(sensors[channel], from_ns, to_ns) for (channel, from_ns), to_ns in ends.items()
    )


@dataclass(frozen=True, slots=True)
class RunActivity:
    """What the elements of a robot did in a run."""

    elements: Sequence[Element]
    """All elements, sensors that the scenario adds included."""
    attribution: Attribution
    """The visits to which steps belong."""
    activity: Mapping[str, ElementActivity]
    """What each joint and gripper did, by name."""
    samples: Samples
    """The samples of the run."""


def with_sensors(
    seen: RunActivity,
    recording: Recording,
    active: Mapping[str, Exposure],
    visits: Sequence[Visit],
) -> tuple[dict[str, Exposure], tuple[Visit, ...]]:
    """Return the exposures over the run, and the visits, with the sensors among the elements.

    `active` and `visits` have the exposures of joints and grippers.
    A sensor in a joint belongs to whom the joint belongs to, another to the current visit.
    """
    samples = seen.samples
    n_steps, step_ns = samples.n_steps, samples.header.step_ns
    spans = reading_spans(recording, n_steps * step_ns)
    sensors = sensor_activity(seen.elements, seen.activity, spans, n_steps, step_ns)
    everywhere = np.zeros(n_steps, dtype=np.int64)
    total = dict(active)
    exposures = [dict(visit.exposures) for visit in visits]
    for name, sensor in sensors.items():
        joint = None if sensor.joint is None else sensor.joint.element.name
        whole = None if joint is None else [active[joint]]
        (total[name],) = sensor_exposures(sensor, whole, everywhere, 1, samples.step_s)
        # Without a reading its time is its joint's, whose owners have their shares already.
        owners = everywhere
        if sensor.reading is not None:
            owners = seen.attribution.assign(joint or name, n_steps, step_ns)
        shares = None
        if joint is not None:
            shares = [visit.exposures.get(joint) or Exposure() for visit in visits]
        result = sensor_exposures(sensor, shares, owners, len(visits), samples.step_s)
        for exposure, share in zip(exposures, result, strict=True):
            if share != Exposure():
                exposure[name] = share
    with_them = tuple(
        replace(visit, exposures=exposure)
        for visit, exposure in zip(visits, exposures, strict=True)
    )
    return total, with_them
