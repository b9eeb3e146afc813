"""The functions of a controller as a table: what each risks, and through which components."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from tracerisk.prm.hybrid.assessment import Assessment, ComponentContribution, StateAssessment
from tracerisk.report.tables import ROOMY, WIDE, add_share_columns, plain, share_cells, table_of

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

MOST_OF_FUNCTION = 6
"""How many components of one function are shown, those that matter most first."""

MOST_FUNCTIONS = 200
"""How many functions are shown, those with the greatest share of the mission's failure."""

Exposures = Mapping[str, Mapping[str, float]]
"""Seconds active, by function and component, over all visits of the run."""


def functions_table(
    assessment: Assessment, exposures: Exposures | None = None, width: int = 80
) -> Table:
    """Return the functions in the order of their call sequence, their components below each.

    The probability and the share of a component are by how much those of its function fall where
    it never fails; shares are parts of the mission's failure probability.
    Of many functions those with the greatest shares are shown.
    """
    shown = riskiest(assessment, MOST_FUNCTIONS)
    count = len(assessment.states)
    title = "Functions"
    if count > len(shown):
        title += f" ({len(shown)} of {count}, those with the greatest share)"
    table = table_of(title)
    table.add_column("#", justify="right", no_wrap=True)
    table.add_column("function and its components", overflow="fold")
    if width >= ROOMY:
        table.add_column("needed", justify="right", no_wrap=True)
    if exposures is not None:
        table.add_column("active s", justify="right", no_wrap=True)
        add_legend(table)
    for heading in ("p failure", "visits", *(("absorbed",) if width >= WIDE else ())):
        table.add_column(heading, justify="right", no_wrap=True)
    add_share_columns(table, width)
    for state in shown:
        for cells in _rows(state, assessment.mission.geometric_cycles, exposures, width):
            table.add_row(*cells)
    return table


def add_legend(table: Table) -> None:
    """Put below a table of a run what its figures are of."""
    table.caption = "active s: all visits; p failure: one visit\n "
    table.caption_justify = "left"
    table.caption_style = ""


def riskiest(assessment: Assessment, most: int) -> list[StateAssessment]:
    """Return the functions with the greatest shares, in the order of their call sequence."""
    ranked = sorted(assessment.states, key=lambda state: -state.absorption_probability)
    names = {state_assessment.name for state_assessment in ranked[:most]}
    return [state for state in assessment.states if state.name in names]


def _rows(
    state: StateAssessment, risk: float, exposures: Exposures | None, width: int
) -> list[list[RenderableType]]:
    from rich.padding import Padding
    from rich.text import Text

    def row(
        sequence: str,
        name: RenderableType,
        needed: str = "",
        active: str = "",
        figures: tuple[str, str, str] = ("", "", ""),
        share: float | None = None,
    ) -> list[RenderableType]:
        cells = [*plain([sequence]), name]
        if width >= ROOMY:
            cells += plain([needed])
        if exposures is not None:
            cells += plain([active])
        cells += plain(figures[: 3 if width >= WIDE else 2])
        return cells + ([] if share is None else share_cells(share, width))

    share = state.absorption_probability / risk if risk > 0.0 else 0.0
    figures = (f"{state.top_event:.2e}", f"{state.expected_visits:.4g}")
    absorbed = f"{state.absorption_probability:.2e}"
    name = Text(state.name, style="bold")
    rows = [row(str(state.call_sequence), name, figures=(*figures, absorbed), share=share)]
    # The greatest first; those alike stay in the order of the block.
    components = sorted(state.components, key=lambda contribution: -contribution.contribution)
    left = len(components) - MOST_OF_FUNCTION if len(components) > MOST_OF_FUNCTION + 1 else 0
    for component in components[: len(components) - left]:
        part = component.contribution / state.top_event if state.top_event > 0.0 else 0.0
        rows.append(
            row(
                "",
                Padding(Text(component.name), (0, 0, 0, 2)),
                units_needed(component),
                _active(exposures, state.name, component),
                (f"{component.contribution:.2e}", "", ""),
                share * part,
            )
        )
    if left:
        rows.append(row("", Padding(Text(f"and {left} more"), (0, 0, 0, 2))))
    if not components:
        rows.append(row("", Padding(Text("(none)"), (0, 0, 0, 2))))
    return rows


def units_needed(component: ComponentContribution) -> str:
    """Return how many units must work, of how many."""
    required = "?" if component.required is None else component.required
    return f"{required} of {component.units}"


def _active(exposures: Exposures | None, function: str, component: ComponentContribution) -> str:
    seconds = (exposures or {}).get(function, {}).get(component.component)
    return "-" if seconds is None else f"{seconds:.2f}"
