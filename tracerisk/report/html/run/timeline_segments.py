"""Which element did what, from when to when: what the rows of the timeline show.

Segments come from the samples of the run, as the trace's exposures do, so that what a row shows
adds up to what the trace says. Where there are no samples, a segment is a whole visit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.common.traced.elements import Exposure
from tracerisk.trace import Trace, Visit
from tracerisk.twin.robots.sensors import IN_JOINTS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from tracerisk.twin.recording.activity import ElementActivity

    Codes = NDArray[np.uint8]

MOVING, HOLDING, GRASPING, BORDERLINE, SOMEWHEN = 1, 2, 4, 8, 16
"""Bits of a segment's state. `SOMEWHEN`: in use during a visit, it is not known when in it."""

_MS = 1e3
_STEP_S = 0.002  # the longest physics step [s]


@dataclass(frozen=True, slots=True)
class Segment:
    """A stretch in which an element's state stays the same."""

    start_s: float
    """Begin of the stretch [s]."""
    stop_s: float
    """End of the stretch [s]."""
    state: int
    """Sum of the bits above."""


@dataclass(frozen=True, slots=True)
class Row:
    """A component and its elements over time."""

    component: str
    """Name of the component; "" for elements bound to no component."""
    segments: tuple[Segment, ...]
    """Stretches of the component, with every bit that any of its elements has."""
    elements: Mapping[str, tuple[Segment, ...]]
    """Stretches of each element by name; empty for a component that is always in use."""
    is_always: bool = False
    """Whether the component is in use from begin to end."""


def visit_spans(
    visits: Sequence[Visit], end_s: float
) -> tuple[tuple[tuple[float, float], ...], ...]:
    """Return when each visit was the current one, as (start, stop) pairs [s] a visit.

    A visit is current from its first command on. When its time is used up before the next one
    begins, the latest visit that has time left is current again, as its command was still live.
    """
    spans: list[list[tuple[float, float]]] = [[] for _ in visits]
    left: list[float] = []
    open_visits: list[int] = []  # those with time left, the latest last
    for index, visit in enumerate(visits):
        now = visit.start_s
        until = visits[index + 1].start_s if index + 1 < len(visits) else max(end_s, now)
        left.append(until - now if visit.duration_s is None else visit.duration_s)
        open_visits.append(index)
        while open_visits and now < until:
            latest = open_visits[-1]
            taken = min(left[latest], until - now)
            # A visit begins within a step and is counted in whole ones: what that leaves of its
            # time is no span.
            if taken > (1e-9 if latest == index else _STEP_S):
                spans[latest].append((now, now + taken))
                left[latest] -= taken
                now += taken
            if left[latest] > _STEP_S:
                break
            open_visits.pop()
    return tuple(tuple(span) for span in spans)


def timeline_rows(
    trace: Trace,
    components: Mapping[str, Sequence[str]],
    activity: Mapping[str, ElementActivity] | None = None,
    step_s: float = 0.002,
) -> tuple[Row, ...]:
    """Return a row for each component, then one for elements that no component is bound to.

    `components` map a component to its elements, none for one that is always in use; `activity`
    is what the samples of the run say of each element, cut to the run, one entry every `step_s`.
    """
    end_s = trace.end.simulated_s or 0.0
    spans = visit_spans(trace.visits, end_s)
    codes = {
        name: _codes(name, states, trace, spans, step_s)
        for name, states in _all_states(trace, activity or {}).items()
    }
    bound = {name for elements in components.values() for name in elements}
    watched = [element.name for element in trace.elements]
    groups = [(name, tuple(elements)) for name, elements in components.items()]
    loose = tuple(name for name in watched if name not in bound)
    if loose:
        groups.append(("", loose))
    rows = []
    for component, elements in groups:
        if component and not elements:
            rows.append(Row(component, (Segment(0.0, end_s, SOMEWHEN),), {}, is_always=True))
            continue
        segments = {
            name: _runs(codes[name], step_s) if name in codes else _by_visit(name, trace, spans)
            for name in elements
        }
        seen = [codes[name] for name in elements if name in codes]
        if seen and len(seen) == len(elements):
            whole = seen[0].copy()
            for codes_of in seen[1:]:
                whole |= codes_of
            together = _runs(whole, step_s)
        else:
            together = _together([segment for name in elements for segment in segments[name]])
        if component or any(segments.values()):
            rows.append(Row(component, together, segments))
    return tuple(rows)


def _all_states(trace: Trace, activity: Mapping[str, ElementActivity]) -> dict[str, Codes]:
    """Return the states of each element that the samples follow over time, by its name."""
    states = {name: _states(element_activity) for name, element_activity in activity.items()}
    for element in trace.elements:
        # A sensor in a joint is in use while the joint is, so it has the joint's states.
        joint = states.get(element.part or "") if element.sensor in IN_JOINTS else None
        if joint is not None:
            states[element.name] = (joint & (MOVING | HOLDING)).astype(joint.dtype)
    return states


def _states(activity: ElementActivity) -> Codes:
    """Return what an element does at each step, (n_steps,)."""
    import numpy as np

    states: Codes = (
        activity.moving * np.uint8(MOVING)
        | activity.holding * np.uint8(HOLDING)
        | activity.grasping * np.uint8(GRASPING)
    ).astype(np.uint8)
    return states


def _codes(
    name: str,
    codes: Codes,
    trace: Trace,
    spans: Sequence[Sequence[tuple[float, float]]],
    step_s: float,
) -> Codes:
    """Return the states of an element with what its visits add to them, (n_steps,)."""
    for visit, own in zip(trace.visits, spans, strict=True):
        exposure = visit.exposures.get(name)
        if exposure is None:
            continue
        for start, stop in own:
            part = codes[round(start / step_s) : round(stop / step_s)]
            if exposure.borderline:
                part[part > 0] |= BORDERLINE
            if exposure.reading_s > 0.0:
                part[part == 0] = SOMEWHEN
    return codes


def _runs(codes: Codes, step_s: float) -> tuple[Segment, ...]:
    import numpy as np

    edges = np.flatnonzero(np.diff(codes)) + 1
    starts = np.concatenate(([0], edges))
    stops = np.concatenate((edges, [len(codes)]))
    return tuple(
        Segment(int(start) * step_s, int(stop) * step_s, int(codes[start]))
        for start, stop in zip(starts, stops, strict=True)
        if start < stop and codes[start]
    )


def _by_visit(
    name: str, trace: Trace, spans: Sequence[Sequence[tuple[float, float]]]
) -> tuple[Segment, ...]:
    """Return the visits in which an element was in use, for one whose seconds are not sampled."""
    segments = []
    for visit, own in zip(trace.visits, spans, strict=True):
        if name in visit.exposures:
            state = _state_of(visit.exposures[name])
            segments += [Segment(start, stop, state) for start, stop in own if state]
    return tuple(sorted(segments, key=lambda segment: segment.start_s))


def _state_of(exposure: Exposure | None) -> int:
    """Return the bits of an exposure; of a log without times, only that it was in use."""
    if exposure is None:
        return SOMEWHEN
    states = (
        (exposure.moving_s, MOVING),
        (exposure.holding_s, HOLDING),
        (exposure.grasping_s, GRASPING),
        (exposure.active_s + exposure.reading_s, SOMEWHEN),
        (float(exposure.borderline), BORDERLINE),
    )
    state = sum(bit for value, bit in states if value > 0.0)
    return 0 if state == BORDERLINE else state | SOMEWHEN if state else 0


def _together(segments: Sequence[Segment]) -> tuple[Segment, ...]:
    """Return the segments of several elements as those of one."""
    edges = sorted(
        edge
        for segment in segments
        for edge in ((segment.start_s, 1, segment.state), (segment.stop_s, -1, segment.state))
    )
    bits = (MOVING, HOLDING, GRASPING, BORDERLINE, SOMEWHEN)
    counts = dict.fromkeys(bits, 0)
    together: list[Segment] = []
    before, state = 0.0, 0
    for time, sign, changed in edges:
        if state and time > before:
            if together and together[-1].stop_s == before and together[-1].state == state:
                together[-1] = Segment(together[-1].start_s, time, state)
            else:
                together.append(Segment(before, time, state))
        for bit in bits:
            counts[bit] += sign if changed & bit else 0
        before, state = time, sum(bit for bit in bits if counts[bit])
    return tuple(together)


def segments_data(segments: Sequence[Segment]) -> list[float]:
    """Return segments as one list of numbers: start [ms], length [ms] and state of each."""
    return [
        value
        for segment in segments
        for value in (_ms(segment.start_s), _ms(segment.stop_s - segment.start_s), segment.state)
    ]


def _ms(seconds: float) -> float:
    value = round(seconds * _MS, 3)
    return int(value) if value == int(value) else value
