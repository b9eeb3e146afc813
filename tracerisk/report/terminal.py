"""What a run or a solved model says on a terminal: one sentence, then the tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from tracerisk.prm.hybrid.assessment import (
    FIXED,
    GEOMETRIC,
    Assessment,
    ComponentImportance,
    MissionFigures,
)
from tracerisk.report.functions_table import Exposures, functions_table
from tracerisk.report.tables import (
    ROOMY,
    add_share_columns,
    counted,
    plain,
    rendered,
    share_cells,
    share_text,
    table_of,
)

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table

MOST_COMPONENTS = 5
"""How many of the components that matter most are shown."""


def render_assessment(
    assessment: Assessment,
    *,
    exposures: Exposures | None = None,
    findings: Sequence[str] = (),
    assumptions: Sequence[str] = (),
    tables: Sequence[RenderableType] = (),
    width: int = 80,
    color: bool = False,
) -> str:
    """Return an assessment as text, the same for the same input on every machine.

    `exposures` are the seconds active where a run is known; `findings` and `assumptions` are
    the caller's lines, shown before those of the assessment; `tables` the caller's, shown below
    that of the components.
    `width` is the number of columns, at least 60; from 110 on there are bars; `color` adds
    escape sequences.
    """
    text = rendered(
        lambda console: print_assessment(
            console,
            assessment,
            exposures=exposures,
            findings=findings,
            assumptions=assumptions,
            tables=tables,
        ),
        width=width,
        color=color,
    )
    return text.rstrip("\n") + "\n"


def print_assessment(
    console: Console,
    assessment: Assessment,
    *,
    exposures: Exposures | None = None,
    findings: Sequence[str] = (),
    assumptions: Sequence[str] = (),
    tables: Sequence[RenderableType] = (),
) -> None:
    """Print the table to a console of rich, with the lines of `render_assessment`."""
    from rich.text import Text

    console.print(Text(mission_sentence(assessment), style="bold"))
    console.print(Text(assessment.statement, style="italic"))
    console.print(Text(_readings(assessment)))
    console.print()
    console.print(functions_table(assessment, exposures, console.width))
    _print_lines(console, "Findings", (*findings, *assessment.findings))
    if assessment.components:
        console.print(_components(assessment.components, console.width))
    for table in tables:
        console.print(table)
    _print_lines(console, "Assumptions", (*assumptions, *assessment.assumptions))


def mission_sentence(assessment: Assessment) -> str:
    """Return what a mission risks, and by most through what, in one sentence."""
    risk = assessment.mission.failure_probability
    if risk == 0.0:
        return f"No hardware failure that is modelled can end a mission of {assessment.model}."
    told = (
        f"Probability that a hardware failure ends a mission of {assessment.model}: "
        f"{_probability(risk)}"
    )
    if not assessment.components:
        return f"{told}."
    first = assessment.components[0]
    return f"{told}, {share_text(first.fussell_vesely)} of it through {first.name}."


_SEEN = 1e-4
"""How far readings differ, relative, where the digits shown may tell them apart."""


def _readings(assessment: Assessment) -> str:
    mission = assessment.mission
    figures = {
        GEOMETRIC: mission.geometric_cycles,
        _fixed_cycles(mission): mission.fixed_cycles,
        "as executed": mission.visits_as_run,
    }
    spread = max(figures.values()) - min(figures.values())
    risk = mission.failure_probability
    relative = spread / risk if risk > 0.0 else 0.0
    told = "; ".join(f"{name} {_probability(value)}" for name, value in figures.items())
    told = f"{told[0].upper()}{told[1:]}: they differ by {100.0 * relative:.2g} %."
    if relative < _SEEN:
        return told
    if mission.reading == GEOMETRIC:
        return f"{told} The first holds: `next` is a distribution."
    return f"{told} The second holds: `next` counts the cycles of a mission."


def _fixed_cycles(mission: MissionFigures) -> str:
    if mission.reading == FIXED and mission.expected_cycles < 1.5:
        # The loops stand behind the entry, each with a number of its own.
        return "fixed cycles"
    return counted(mission.expected_cycles, "fixed cycle")


def _components(components: Sequence[ComponentImportance], width: int) -> Table:
    shown = components[:MOST_COMPONENTS]
    title = "Components that matter most"
    if len(components) > len(shown):
        title += f" ({len(shown)} of {len(components)})"
    table = table_of(title)
    table.add_column("component", overflow="fold")
    add_share_columns(table, width, heading="Fussell-Vesely" if width >= ROOMY else "share")
    measures: dict[str, Callable[[ComponentImportance], str]] = {
        "criticality": lambda each: share_text(each.criticality),
        "RRW": lambda each: f"{each.risk_reduction_worth:.4g}",
        "RAW": lambda each: f"{each.risk_achievement_worth:.3g}",
        "tenfold": lambda each: f"{each.tenfold:.4g}",
    }
    if width < ROOMY:
        # The same as the share, nearly, and the same for all whose failure ends a mission.
        del measures["criticality"], measures["RAW"]
    for heading in measures:
        table.add_column(heading, justify="right", no_wrap=True)
    for component in shown:
        table.add_row(
            *plain([component.name]),
            *share_cells(component.fussell_vesely, width),
            *plain([measure(component) for measure in measures.values()]),
        )
    return table


def _print_lines(console: Console, title: str, lines: Sequence[str]) -> None:
    from rich.table import Table
    from rich.text import Text

    if not lines:
        return
    console.print(Text(title, style="bold"))
    # A column of its own for the dash keeps the lines of one entry flush.
    grid = Table.grid(padding=(0, 1))
    for line in dict.fromkeys(lines):
        grid.add_row(*plain(["-", line]))
    console.print(grid)
    console.print()


def _probability(value: float) -> str:
    return f"{value:.2e}"
