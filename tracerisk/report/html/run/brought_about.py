"""What the run brought about: where objects end, and what the arm and the cell did, in order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tracerisk.common.outcome.arm import Position
from tracerisk.common.outcome.outcome import CellUse, GripperUse, Outcome, Rest, Step
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Section
from tracerisk.report.html.tables import Cell, Column, Row, Table, numbers, row_of, texts
from tracerisk.trace import SuccessCondition

MOST_UNFOLDED = 12
"""How many steps are shown before they are folded."""


def brought_about_section(report: ReportInput) -> Section | None:
    """Return what the run brought about; `None` where no run is known that shows it."""
    success = () if report.trace is None else report.trace.success
    outcome = None if report.trace is None else report.trace.outcome
    if outcome is None or not (outcome.objects or outcome.steps or success):
        return None
    html = rendered(
        "brought_about.html.j2",
        success=_success(success) if success else None,
        objects=_objects(outcome) if outcome.objects else None,
        way=_way(outcome) if outcome.steps else None,
        streams=outcome.streams,
        most=MOST_UNFOLDED,
    )
    return Section("brought-about", "What the run brought about", html)


def _success(conditions: Sequence[SuccessCondition]) -> Table:
    rows = [
        row_of(condition.words, "met" if condition.is_met else "missed") for condition in conditions
    ]
    return Table(
        "success", "What the mission has to bring about", texts("condition", "run"), tuple(rows)
    )


def _objects(outcome: Outcome) -> Table:
    moved = {object_outcome.name for object_outcome in outcome.moved}
    rows = [
        row_of(
            Cell(object_outcome.name, note="" if object_outcome.name in moved else "not moved"),
            _place(object_outcome.begin_m),
            _place(object_outcome.end_m),
            f"{object_outcome.tilt_deg:.0f}",
            "-" if object_outcome.heading_deg is None else f"{object_outcome.heading_deg:.0f}",
            object_outcome.held_in or object_outcome.rests_on or "-",
        )
        for object_outcome in outcome.objects
    ]
    columns = (
        Column("object"),
        Column("begin", "metres, in the scene"),
        Column("end", "metres, in the scene"),
        Column("tilt", "degrees from the vertical", is_number=True),
        Column("turned", "degrees about the vertical", is_number=True),
        Column("on or in"),
    )
    return Table("objects", "Objects", columns, tuple(rows))


def _way(outcome: Outcome) -> Table:
    columns = (*texts("step", "what", "where or with what"), *numbers("took s", "stayed s"))
    return Table(
        "way", "Rests, grips and uses of the cell, in order", columns, tuple(_rows(outcome))
    )


def _rows(outcome: Outcome) -> Iterator[Row]:
    for number, step in enumerate(outcome.steps, start=1):
        yield row_of(str(number), *_cells(step))


def _cells(step: Step) -> tuple[str, str, str, str]:
    if isinstance(step, Rest):
        took, stayed = f"{step.took_s:.1f}", f"{step.held_s:.1f}"
        return "rest of the tool", f"{_place(step.tool_m)} m", took, stayed
    if isinstance(step, GripperUse):
        held = f"holds {step.holds}" if step.holds else "holds nothing"
        return f"{step.gripper}, {100.0 * step.opened:.0f} % open", held, "", ""
    return _use(step)


def _use(use: CellUse) -> tuple[str, str, str, str]:
    failed = "" if use.succeeded else ", without success"
    return f"{use.kind} {use.interface}{failed}", use.content or "defaults", "", ""


def _place(place: Position) -> str:
    return ", ".join(f"{value:.3f}" for value in place)
