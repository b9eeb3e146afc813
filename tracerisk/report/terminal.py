"""The table at the end of a run, for a terminal of 80 columns or none at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from tracerisk.prm.assessment import (
    Assessment,
    ComponentContribution,
    ComponentImportance,
    StateAssessment,
)
from tracerisk.report.tables import counted, plain, rendered, table_of

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table

MOST_COMPONENTS = 5
"""How many of the components that matter most are shown."""

Exposures = Mapping[str, Mapping[str, float]]
"""Seconds active, by function and component, over all visits of the run."""


def render_assessment(
    assessment: Assessment,
    *,
    exposures: Exposures | None = None,
    findings: Sequence[str] = (),
    assumptions: Sequence[str] = (),
    tables: Sequence[Table] = (),
    width: int = 80,
    color: bool = False,
) -> str:
    """Return the table as text, the same for the same input on every machine.

    `exposures` are the seconds active where a run is known; `findings` and `assumptions` are
    the caller's lines, shown before those of the assessment; `tables` the caller's, shown below
    that of the components.
    `width` is the number of columns, at least 60; `color` adds escape sequences.
    """
    return rendered(
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


def print_assessment(
    console: Console,
    assessment: Assessment,
    *,
    exposures: Exposures | None = None,
    findings: Sequence[str] = (),
    assumptions: Sequence[str] = (),
    tables: Sequence[Table] = (),
) -> None:
    """Print the table to a console of rich, with the lines of `render_assessment`."""
    parts: list[RenderableType] = [
        _functions(assessment.states, exposures),
        _mission(assessment),
    ]
    if assessment.components:
        parts.append(_components(assessment.components))
    for part in (*parts, *tables):
        console.print(part)
    _print_lines(console, "Findings", (*findings, *assessment.findings))
    _print_lines(console, "Assumptions", (*assumptions, *assessment.assumptions))
    console.print(assessment.statement, style="italic", markup=False, soft_wrap=True)


def _functions(states: Sequence[StateAssessment], exposures: Exposures | None) -> Table:
    table = table_of("Functions")
    table.add_column("#", justify="right", no_wrap=True)
    table.add_column("function", overflow="fold")
    table.add_column("components", overflow="fold")
    table.add_column("needed", justify="right", no_wrap=True)
    if exposures is not None:
        table.add_column("active s", justify="right", no_wrap=True)
    for heading in ("p failure", "visits", "absorbed"):
        table.add_column(heading, justify="right", no_wrap=True)
    for state in states:
        # A row per component keeps each exposure beside its component, however names fold.
        for index, component in enumerate(state.components or (None,)):
            first = index == 0
            cells = [
                str(state.call_sequence) if first else "",
                state.name if first else "",
                "(none)" if component is None else component.name,
                "" if component is None else _needed(component),
            ]
            if exposures is not None:
                cells.append(_exposure(exposures, state.name, component))
            cells += [
                _probability(state.top_event) if first else "",
                f"{state.expected_visits:.4g}" if first else "",
                _probability(state.absorption_probability) if first else "",
            ]
            table.add_row(*plain(cells))
    return table


def _mission(assessment: Assessment) -> Table:
    mission = assessment.mission
    table = table_of("Mission failure probability")
    cells = {
        "by the chain": mission.failure_probability,
        f"{counted(mission.expected_cycles, 'cycle')}, fixed": mission.fixed_cycles,
        "visits as they ran": mission.visits_as_run,
    }
    for heading in cells:
        table.add_column(heading, justify="right")
    table.add_column("they differ by", justify="right")
    spread = max(cells.values()) - min(cells.values())
    relative = spread / mission.failure_probability if mission.failure_probability > 0.0 else 0.0
    table.add_row(*plain([*map(_probability, cells.values()), f"{100.0 * relative:.2g} %"]))
    return table


def _components(components: Sequence[ComponentImportance]) -> Table:
    shown = components[:MOST_COMPONENTS]
    title = "Components that matter most"
    if len(components) > len(shown):
        title += f" ({len(shown)} of {len(components)})"
    table = table_of(title)
    table.add_column("component", overflow="fold")
    for heading in ("Fussell-Vesely", "criticality", "RRW", "RAW", "tenfold"):
        table.add_column(heading, justify="right")
    for component in shown:
        table.add_row(
            *plain(
                [
                    component.name,
                    _share(component.fussell_vesely),
                    _share(component.criticality),
                    f"{component.risk_reduction_worth:.4g}",
                    f"{component.risk_achievement_worth:.3g}",
                    f"{component.tenfold:.4g}",
                ]
            )
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
    for line in lines:
        grid.add_row(*plain(["-", line]))
    console.print(grid)
    console.print()


def _needed(component: ComponentContribution) -> str:
    required = "?" if component.required is None else component.required
    return f"{required} of {component.units}"


def _exposure(exposures: Exposures, function: str, component: ComponentContribution | None) -> str:
    if component is None:
        return ""
    seconds = exposures.get(function, {}).get(component.name)
    return "-" if seconds is None else f"{seconds:.2f}"


def _probability(value: float) -> str:
    return f"{value:.2e}"


def _share(value: float) -> str:
    return f"{100.0 * value:.3g} %"
