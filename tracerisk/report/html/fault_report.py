"""The report of a run with a fault: its effect, timeline and replay."""

from __future__ import annotations

from collections.abc import Sequence

from tracerisk.report.html.page import asset, page, rendered
from tracerisk.report.html.section import Section
from tracerisk.trace import Trace


def render_fault_report(
    trace: Trace, fault: str | None, lines: Sequence[str], sections: Sequence[Section]
) -> str:
    """Return the page of a run with a fault, the same for the same input.

    `fault` describes it, `None` for the run without one beside it, `lines` its effect;
    `sections` show the run. It has no figure of risk: those are of whole reports.
    """
    lead = rendered(
        "fault.html.j2",
        name=trace.controller,
        context=(trace.robot, trace.scene),
        sentence="The run without a fault." if fault is None else f"A run with a fault: {fault}.",
    )
    outcome = rendered("list.html.j2", lines=lines, lead="", empty="")
    assumed = rendered("list.html.j2", lines=trace.assumptions, lead="", empty="Nothing.")
    result = (
        Section("outcome", "Effect", outcome, js=asset("beside.js")),
        *sections,
        Section("assumptions", "Assumptions", assumed),
    )
    return page(f"{trace.controller} with {fault or 'no fault'}", lead, result)
