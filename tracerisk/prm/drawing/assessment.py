"""An assessment as tables, and each component's part in the failures as bars."""

from __future__ import annotations

from html import escape
from typing import Any

from tracerisk.prm.drawing.svg import WORD_HEIGHT, Canvas, word_width
from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.prm.numbers.table import Table

_MOST_BARS = 30
_MOST_NOTES = 30
_BAR = 240.0
_ROW = WORD_HEIGHT + 6.0


def assessment_svg(assessment: Assessment) -> str:
    """Return bars of the Fussell-Vesely importance of the components, at most 30 of them."""
    components = assessment.components[:_MOST_BARS]
    words = max((word_width(component.name) for component in components), default=0.0)
    canvas = Canvas()
    for rank, component in enumerate(components):
        y = rank * _ROW + _ROW / 2
        share = min(max(component.fussell_vesely, 0.0), 1.0)
        canvas.word(words, y, component.name, anchor="end")
        canvas.box(words + 8.0 + share * _BAR / 2, y, share * _BAR, WORD_HEIGHT - 4, fill="#9db4d6")
        canvas.word(
            words + 14.0 + share * _BAR, y, f"{component.fussell_vesely:.3g}", anchor="start"
        )
    title = f"{assessment.model}: share of each component in the mission's failure"
    return canvas.svg(words + _BAR + 80.0, len(components) * _ROW, title)


def assessment_html(assessment: Assessment) -> str:
    """Return the figures of an assessment as HTML: mission, functions, components."""
    mission = assessment.mission
    tables: list[tuple[str, Table[Any]]] = [
        ("Functions", Table(assessment.states)),
        ("Components", Table(assessment.components)),
    ]
    notes = "".join(f"<li>{escape(note)}</li>" for note in _notes(assessment))
    return (
        f"<h4>{escape(assessment.model)}</h4>"
        f"<p>Mission failure probability {mission.failure_probability:.6g} "
        f"(fixed cycles {mission.fixed_cycles:.6g}, as executed {mission.visits_as_run:.6g})</p>"
        + "".join(f"<h5>{head}</h5>{table._repr_html_()}" for head, table in tables)
        + (f"<ul>{notes}</ul>" if notes else "")
        + f"<p>{escape(assessment.statement)}</p>"
    )


def assessment_text(assessment: Assessment) -> str:
    """Return the figures of an assessment as text: mission, functions, components."""
    mission = assessment.mission
    return "\n".join(
        (
            f"{assessment.model}: mission failure probability {mission.failure_probability:.6g} "
            f"(fixed cycles {mission.fixed_cycles:.6g}, as executed {mission.visits_as_run:.6g})",
            *("", "Functions", str(Table(assessment.states))),
            *("", "Components", str(Table(assessment.components))),
            "",
            *(f"- {note}" for note in _notes(assessment)),
            assessment.statement,
        )
    )


def _notes(assessment: Assessment) -> list[str]:
    notes = [*assessment.assumptions, *assessment.findings]
    more = len(notes) - _MOST_NOTES
    return [*notes[:_MOST_NOTES], f"and {more} more"] if more > 0 else notes
