"""What a run came to, as far as its mission goes: enough to judge it beside another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tracerisk.instrument.commands import Command, in_order
from tracerisk.instrument.marks.call_log import CALLS, Calls
from tracerisk.instrument.recording import Recording
from tracerisk.trace import Trace
from tracerisk.twin.recording.samples import Samples, has_samples, read_samples

Position = tuple[float, float, float]
_NO_CALLS = Calls(frozenset(), (), frozenset(), frozenset())


@dataclass(frozen=True, slots=True)
class MissionRun:
    """One run, as `judge` compares it."""

    trace: Trace
    """The trace of the run."""
    arrivals: tuple[Mapping[str, float], ...] = ()
    """The positions of the robot's joints at the end of each visit of the trace [rad or m]."""
    things: Mapping[str, Position] | None = None
    """Where each thing that can be moved was at the end [m]; `None` where the run was cut."""
    recording: Recording = field(default_factory=Recording)
    """Its commands, notes and findings."""
    samples: Samples | None = None
    """Its samples; `None` where none were recorded."""
    is_decided: bool = False
    """Whether the run was ended because its fate was decided: how it would end is not known."""
    unit_moved: float = 0.0
    """How far the failed joint was from where it was without a failure, within a second [rad, m]"""

    @property
    def commands(self) -> tuple[Command, ...]:
        """All commands, those that moved nothing too, in the order of issue."""
        return tuple(in_order((*self.recording.commands, *self.recording.refused)))

    @property
    def calls(self) -> Calls:
        """The calls that the controller executed."""
        note = self.recording.note(CALLS)
        return _NO_CALLS if note is None else Calls.of(note)

    @property
    def has_ended(self) -> bool:
        """Whether the controller ended the run: it waits for nothing, and no limit was reached."""
        return not self.is_decided and self.trace.end.cause in ("ended", "exited", "raised")

    def moved_after(self, from_s: float) -> float:
        """Return how far a joint was at most, later than `from_s` [s], from where it was then.

        In [rad], or [m] of a sliding one.
        """
        samples = self.samples
        if samples is None or from_s * 1e9 >= samples.n_steps * samples.header.step_ns:
            return 0.0
        later = samples.position[round(from_s / samples.step_s) :]
        return float(np.abs(later - later[0]).max(initial=0.0)) if len(later) else 0.0


def mission_run(
    trace: Trace,
    folder: Path,
    recording: Recording,
    *,
    unit: str | None = None,
    fault_s: float = 0.0,
    nominal: Samples | None = None,
    is_decided: bool = False,
) -> MissionRun:
    """Return a run whose recording is in `folder`; `unit` failed at `fault_s` [s].

    Raises LogError where the recording is damaged.
    """
    if not has_samples(folder):
        return MissionRun(trace, recording=recording, is_decided=is_decided)
    samples = read_samples(folder)
    return MissionRun(
        trace,
        _arrivals(trace, samples),
        _things(samples),
        recording,
        samples,
        is_decided,
        _moved(samples, nominal, unit, fault_s),
    )


def _arrivals(trace: Trace, samples: Samples) -> tuple[Mapping[str, float], ...]:
    """Return the joints' positions as each visit ends: when the next begins, or the run is over."""
    names = samples.header.joints
    ends = [visit.start_s for visit in trace.visits[1:]]
    ends.append(trace.end.simulated_s or 0.0)
    arrivals = []
    for end_s in ends[: len(trace.visits)]:
        step = min(max(0, round(end_s / samples.step_s)), samples.n_steps - 1)
        arrivals.append(dict(zip(names, map(float, samples.position[step]), strict=True)))
    return tuple(arrivals)


def _things(samples: Samples) -> Mapping[str, Position] | None:
    pose = samples.end_pose
    if pose is None:
        return None
    header = samples.header
    things: dict[str, Position] = {}
    for name, at in zip(header.free_bodies, header.free_at, strict=True):
        if at + 3 <= len(pose):
            x, y, z = map(float, pose[at : at + 3])
            things[name] = (x, y, z)
    return things


def _moved(samples: Samples, nominal: Samples | None, unit: str | None, fault_s: float) -> float:
    joint = (unit or "").partition("/")[0]  # also of an encoder
    if nominal is None or joint not in samples.header.joints:
        return 0.0
    column = samples.header.joints.index(joint)
    first = round(fault_s / samples.step_s)
    stop = min(first + round(1.0 / samples.step_s), samples.n_steps, nominal.n_steps)
    if stop <= first:
        return 0.0
    off = samples.position[first:stop, column] - nominal.position[first:stop, column]
    return float(np.abs(off).max())
