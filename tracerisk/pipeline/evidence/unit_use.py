"""What each unit of a robot did at each step of a run, and in whose visit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.evidence.cells import Use
from tracerisk.common.hardware.model import State
from tracerisk.common.hardware.use import STATES
from tracerisk.common.traced.elements import Exposure
from tracerisk.instrument.ownership import attribute
from tracerisk.instrument.recording import read_recording
from tracerisk.pipeline.trace.run_files import EVENTS, MISSION_END
from tracerisk.pipeline.trace.sensors import reading_spans
from tracerisk.twin.recording.activity import ElementActivity, element_activity
from tracerisk.twin.recording.exposure import exposure
from tracerisk.twin.recording.samples import read_samples
from tracerisk.twin.recording.sensor_activity import sensor_activity

if TYPE_CHECKING:
    from tracerisk.config import Settings
    from tracerisk.trace import Trace
    from tracerisk.twin.robots.robot import Robot

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class UnitUse:
    """What one unit did at each step of a run; every array is (n_steps,)."""

    name: str
    """The name of the unit in the twin."""
    active: Flags
    """Whether the unit was in use."""
    states: tuple[Flags, Flags, Flags]
    """Moving, holding, grasping."""
    owner: NDArray[np.int64]
    """The index of the visit to which the use belongs; -1 for none."""
    step_s: float
    """The physics step [s]."""
    measure: Callable[[Flags], Exposure]
    """Returns the exposure of the unit over the steps that are set."""

    def clock_at(self, step: int) -> tuple[float, tuple[float, float, float]]:
        """Return the time in use before a step, all of it and by state [s]."""
        moving, holding, grasping = (
            float(state[:step].sum()) * self.step_s for state in self.states
        )
        return float(self.active[:step].sum()) * self.step_s, (moving, holding, grasping)

    def use_at(self, step: int) -> Use:
        """Return what the unit did at a step; a grasp goes before what else it did."""
        for state, flags in zip(reversed(STATES), reversed(self.states), strict=True):
            if flags[step]:
                return state
        return "active" if self.active[step] else "idle"

    def flags(self, when: Iterable[State]) -> Flags:
        """Return where the unit was in any of the states; in use at all where none is given."""
        wanted = [flags for state, flags in zip(STATES, self.states, strict=True) if state in when]
        reduce: Flags = np.logical_or.reduce(wanted) if wanted else self.active
        return reduce


def unit_uses(
    folder: Path, trace: Trace, robot: Robot, settings: Settings, always: Sequence[str]
) -> Mapping[str, UnitUse]:
    """Return the use of each unit of a recorded run, by name; those of `always` are always in use.

    Raises LogError where the recording in `folder` is damaged.
    """
    recording = read_recording(folder / EVENTS)
    samples = read_samples(folder)
    n_steps, step_ns = samples.n_steps, samples.header.step_ns
    mission_end = recording.note(MISSION_END)
    if mission_end is not None:
        n_steps = min(n_steps, -(-mission_end["ns"] // step_ns))
    attribution = attribute(
        recording,
        states=settings.states,
        helpers=settings.helpers,
        end_ns=round((trace.end.simulated_s or 0.0) * 1e9),
    )
    activity = element_activity(samples, robot)
    none = np.zeros(n_steps, dtype=np.bool_)

    def use(
        name: str,
        active: Flags,
        states: Sequence[Flags],
        owner: str,
        element: ElementActivity | None = None,
    ) -> UnitUse:
        moving, holding, grasping = (state[:n_steps] for state in states)
        active = active[:n_steps]

        def measure(steps: Flags) -> Exposure:
            over = np.zeros(samples.n_steps, dtype=np.bool_)
            over[:n_steps] = steps
            if element is not None:
                return exposure(element, over, samples.step_s)
            seconds = [
                float((state[:n_steps] & steps).sum()) * samples.step_s
                for state in (*states, active)
            ]
            moving_s, holding_s, _, active_s = seconds
            return Exposure(moving_s=moving_s, holding_s=holding_s, active_s=active_s)

        owners = attribution.assign(owner, n_steps, step_ns)
        return UnitUse(name, active, (moving, holding, grasping), owners, samples.step_s, measure)

    uses = {
        name: use(name, item.active, (item.moving, item.holding, item.grasping), name, item)
        for name, item in activity.items()
    }
    spans = reading_spans(recording, samples.n_steps * step_ns)
    for name, sensor in sensor_activity(
        trace.elements, activity, spans, samples.n_steps, step_ns
    ).items():
        joint = sensor.joint
        states = (none,) * 3 if joint is None else (joint.moving, joint.holding, none)
        active = none if joint is None else joint.active
        if sensor.reading is not None:
            active = sensor.reading | active[: len(sensor.reading)] if joint else sensor.reading
        uses[name] = use(name, active, states, name if joint is None else joint.element.name)
    for name in always:
        uses[name] = use(name, ~none, (none, none, none), name)
    return uses
