"""The timeline: functions and components over the time of the run, and the replay beside it.

One cursor belongs to both. Whoever cannot see them has the same in a table, and in words for the
time at which the cursor is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.traced.elements import Contact, Exposure
from tracerisk.report.html.page import asset, rendered
from tracerisk.report.html.run.replay import Replay, replay_data
from tracerisk.report.html.run.timeline_segments import (
    Row,
    segments_data,
    timeline_rows,
    visit_spans,
)
from tracerisk.report.html.section import Data, Section
from tracerisk.report.html.tables import Cell, Column, Table, row_of, texts
from tracerisk.trace import Trace, Visit

if TYPE_CHECKING:
    from tracerisk.twin.faults.fault import Fault

NAME = "timeline"
"The id of the section, which stands before all others."
TIMELINE = "timeline-data"
"""The id of the data within the page."""
SPEEDS = ("0.25", "0.5", "1", "2", "4", "8")
"""How many times as fast as it ran a run may be played."""

_CHART = ("timeline_draw", "timeline_names", "timeline_tips", "timeline")
_REPLAY = (
    "replay_kinematics",
    "replay_shapes",
    "replay_camera",
    "replay_draw",
    "replay_colours",
    "replay_risk",
    "replay_labels",
    "replay_steer",
    "replay_now",
    "replay",
    "replay_page",
)
_MOST_LISTED = 1000  # visits in the table; the chart has them all
_MOST_MARKS = 6  # in sight below the chart; more are folded


def timeline_section(
    trace: Trace,
    components: Mapping[str, Sequence[str]],
    *,
    replay: Replay | None = None,
    no_replay: str = "",
    faults: Sequence[Fault] = (),
) -> Section:
    """Return the section that shows a run over time, with its replay where there is one.

    `no_replay` says why there is none, and how to get one; "" where nobody wants to know.

    `faults` are those with which it ran: they are marks on the chart, as findings are.

    `components` map each component of the hardware description to its elements, none for one that
    is always in use.
    """
    names = model_names([function.ref for function in trace.functions])
    marks = _marks(trace, faults)
    data = timeline_data(trace, components, names, replay) | {"marks": marks}
    html = rendered(
        "timeline.html.j2",
        has_replay=replay is not None,
        notes=replay.notes if replay is not None else (),
        no_replay=no_replay,
        speeds=SPEEDS,
        marks=marks,
        most_marks=_MOST_MARKS,
        table=_table(trace, names),
        left_out=max(len(trace.visits) - _MOST_LISTED, 0),
    )
    scripts = ("timeline_time", *(_REPLAY if replay is not None else ()), *_CHART)
    styles = ("timeline", *(("replay",) if replay is not None else ()))
    return Section(
        name=NAME,
        title="Replay and timeline" if replay is not None else "Timeline",
        html=html,
        beside=None if replay is None else rendered("replay.html.j2", speeds=SPEEDS),
        css="\n".join(asset(f"{style}.css") for style in styles),
        js="\n".join(asset(f"{script}.js") for script in scripts),
        data=(
            Data.of_json(TIMELINE, data),
            *(replay_data(replay) if replay is not None else ()),
        ),
        summary="Replay" if replay is not None else "Timeline",
    )


def timeline_data(
    trace: Trace,
    components: Mapping[str, Sequence[str]],
    names: Mapping[FunctionRef, str],
    replay: Replay | None = None,
) -> dict[str, Any]:
    """Return what the script of the timeline reads, as JSON has it; times are in [s].

    Segments are lists of start [ms], length [ms] and state, see `timeline_segments`.
    """
    end_s = trace.end.simulated_s or 0.0
    activity = None if replay is None else replay.activity
    step_s = 0.002 if replay is None else replay.step_s
    rows = timeline_rows(trace, components, activity, step_s)
    order = {function.ref: index for index, function in enumerate(trace.functions)}
    spans = visit_spans(trace.visits, end_s)
    return {
        "end": round(end_s, 6),
        "functions": [names[function.ref] for function in trace.functions],
        "visits": [
            {
                "function": order[visit.function],
                "outcome": visit.outcome,
                "spans": [[round(time, 6) for time in span] for span in own],
                "start": round(visit.start_s, 6),
                "contacts": [_contact(contact) for contact in visit.contacts],
                "held": [
                    {"gripper": payload.gripper, "object": payload.object, "mass": payload.mass_kg}
                    for payload in visit.payloads
                ],
            }
            for visit, own in zip(trace.visits, spans, strict=True)
        ],
        "rows": [_row(row) for row in rows],
        "sampled": replay is not None,
    }


def _marks(trace: Trace, faults: Sequence[Fault]) -> list[dict[str, Any]]:
    """Return the instants that are marked, in the order of time [s]: faults and findings."""
    rows = [(fault.time_s, "fault", fault.words) for fault in faults]
    for finding in trace.findings:
        if finding.time_s is not None:
            place = "" if finding.location is None else f"{finding.location}: "
            rows.append((finding.time_s, "finding", f"{place}{finding.message}"))
    return [
        {"time": round(time, 6), "kind": kind, "text": text}
        for time, kind, text in sorted(rows, key=lambda mark: mark[0])
    ]


def _row(row: Row) -> dict[str, Any]:
    return {
        "component": row.component,
        "always": row.is_always,
        "segments": segments_data(row.segments),
        "elements": [
            {"name": name, "segments": segments_data(own)} for name, own in row.elements.items()
        ],
    }


def _contact(contact: Contact) -> dict[str, Any]:
    return {
        "link": contact.link,
        "other": contact.other,
        "start": round(contact.start_s, 6),
        "stop": round(contact.start_s + contact.touching_s, 6),
        "force": round(contact.force_n, 3),
        "expected": contact.expected,
    }


def _table(trace: Trace, names: Mapping[FunctionRef, str]) -> Table:
    """Return the visits as a table: what the chart shows, in words."""
    rows = []
    for number, visit in enumerate(trace.visits[:_MOST_LISTED], start=1):
        name = names[visit.function]
        duration = "" if visit.duration_s is None else f"{visit.duration_s:.3f}"
        times = (f"{visit.start_s:.3f}", duration)
        cells = (str(number), Cell(name, function=name), *times, visit.outcome, _use(visit))
        rows.append(row_of(*cells, function=name))
    columns = (
        *texts("Visit", "Function"),
        Column("Start", "s", is_number=True),
        Column("Duration", "s", is_number=True),
        *texts("Outcome", "Use of the hardware"),
    )
    return Table("visits", "Visits of the run, in their order", columns, tuple(rows))


def _use(visit: Visit) -> str:
    return "; ".join(f"{name}: {_spent(visit.exposures[name])}" for name in sorted(visit.exposures))


def _spent(exposure: Exposure | None) -> str:
    """Return the times of an exposure in words."""
    if exposure is None:
        return "in use"
    times = (
        ("moving", exposure.moving_s),
        ("holding", exposure.holding_s),
        ("grasping", exposure.grasping_s),
        ("reading", exposure.reading_s),
    )
    lines = [f"{word} {seconds:.2f} s" for word, seconds in times if seconds > 0.0]
    return ", ".join([*lines, *(["borderline"] if exposure.borderline else [])]) or "in use"
