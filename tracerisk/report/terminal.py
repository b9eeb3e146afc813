"""What a run or a solved model says on a terminal: one sentence, then the tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.prm.hybrid.assessment import (
    GEOMETRIC,
    Assessment,
    ComponentImportance,
    MissionFigures,
)
from tracerisk.report.functions_table import Exposures, add_legend, functions_table, riskiest
from tracerisk.report.tables import (
    ROOMY,
    add_share_columns,
    counted,
    filled,
    part_of,
    plain,
    rendered,
    share_cells,
    share_text,
    table_of,
)

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table

MOST_BRIEF = 8
"""How many functions a brief table shows."""
MOST_PARTS = 3
"""How many components and findings stand below it."""
MOST_COMPONENTS = 5
"""How many of the components that matter most are shown."""


def render_assessment(
    assessment: Assessment,
    exposures: Exposures | None = None,
    findings: Sequence[str] = (),
    assumptions: Sequence[str] = (),
    tables: Sequence[RenderableType] = (),
    paper: Paper = PAPER,
    band: str = "",
    following: Sequence[str] = (),
) -> str:
    """Return an assessment as text, the same for the same input on every machine.

    `exposures` are the seconds active where a run is known; `findings` and `assumptions` are
    the caller's lines, shown before those of the assessment; `tables` the caller's, shown below
    that of the components. `band` is a sentence on the uncertainty of the figure, `following`
    are lines on what to do next.
    It has 60 columns at least; from 110 on there are bars.
    """
    from rich.text import Text

    def write(console: Console) -> None:
        _print_sentences(console, assessment, band)
        if readings := _readings(assessment):
            console.print(Text(readings))
        console.print()
        console.print(functions_table(assessment, exposures, console.width))
        _print_lines(console, "Findings", (*findings, *assessment.findings))
        if assessment.components:
            console.print(_components(assessment.components, console.width))
        if assessment.undetected_components:
            title = "Components that matter most for what is undetected"
            console.print(_components(assessment.undetected_components, console.width, title))
        for table in tables:
            console.print(table)
        _print_lines(console, "Assumptions", (*assumptions, *assessment.assumptions))
        for line in following:
            console.print(Text(filled(line, console.width)))

    return rendered(write, paper).rstrip("\n") + "\n"


def _print_sentences(console: Console, assessment: Assessment, band: str) -> None:
    """Print the mission's figure, how far it may be off if that is known, and what it is not."""
    from rich.text import Text

    console.print(Text(filled(mission_sentence(assessment), console.width), style="bold"))
    undetected = undetected_sentence(assessment.mission, _probability, has_share=True)
    if undetected:
        console.print(Text(filled(undetected, console.width)))
    if band:
        console.print(Text(filled(band, console.width)))
    console.print(Text(assessment.statement, style="italic"))


def render_brief(
    assessment: Assessment,
    exposures: Exposures | None = None,
    findings: Sequence[str] = (),
    following: Sequence[str] = (),
    paper: Paper = PAPER,
    band: str = "",
) -> str:
    """Return what fits a screen: the sentence, a row a function, what matters most, what next.

    `exposures`, `findings` and `band` as in `render_assessment`; `following` are lines on what to
    do next.
    """
    from rich.text import Text

    shown = riskiest(assessment, MOST_BRIEF)
    risk = assessment.mission.geometric_cycles
    table = table_of(_title(len(assessment.states), len(shown)))
    table.add_column("#", justify="right", no_wrap=True)
    table.add_column("function", overflow="fold")
    headings = (*(("active s",) if exposures is not None else ()), "p failure", "visits")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    add_share_columns(table, paper.width)
    if exposures is not None:
        add_legend(table)
    for state in shown:
        used = [] if exposures is None else [_longest(exposures.get(state.name, {}))]
        figures = [*used, f"{state.top_event:.2e}", f"{state.expected_visits:.4g}"]
        share = state.absorption_probability / risk if risk > 0.0 else 0.0
        cells = plain([str(state.call_sequence), state.name, *figures])
        table.add_row(*cells, *share_cells(share, paper.width))

    def write(console: Console) -> None:
        _print_sentences(console, assessment, band)
        console.print(table)
        parts = [
            f"{component.name} {share_text(component.fussell_vesely)}"
            for component in assessment.components[:MOST_PARTS]
        ]
        if parts:
            console.print(
                Text(filled(f"Parts that matter most: {', '.join(parts)}.", console.width))
            )
        reported = [*findings, *assessment.findings]
        lines = reported[:MOST_PARTS]
        if len(reported) > MOST_PARTS:
            lines.append(f"and {len(reported) - MOST_PARTS} more findings")
        if lines:
            console.print(_list(lines))
        for line in following:
            console.print(Text(filled(line, console.width)))

    return rendered(write, paper)


def _title(count: int, shown: int) -> str:
    if count > shown:
        return f"{shown} of {count} functions, by share"
    return "Functions"


def _longest(active: Mapping[str, float]) -> str:
    """Return the time of the component that is longest in use [s]."""
    return f"{max(active.values()):.2f}" if active else ""


def mission_sentence(assessment: Assessment) -> str:
    """Return what a mission risks, and by most through what, in one sentence."""
    risk = assessment.mission.failure_probability
    if risk == 0.0:
        return f"No hardware failure that is modelled can end a mission of {assessment.model}."
    text = (
        f"Probability that a hardware failure ends a mission of {assessment.model}: "
        f"{_probability(risk)}"
    )
    if not assessment.components:
        return f"{text}."
    first = assessment.components[0]
    return f"{text}, {share_text(first.fussell_vesely)} of it through {first.name}."


def undetected_sentence(
    mission: MissionFigures, words_of: Callable[[float], str], *, has_share: bool = False
) -> str:
    """Return how much of the mission's failure nobody notices; empty where that is not known.

    `words_of` returns how a probability is written; if asked, its share follows the undetected one.
    """
    undetected, late = mission.undetected_probability, mission.stopped_late_probability
    safely = mission.stopped_safely_probability
    if undetected is None or late is None or safely is None:
        return ""
    text = f"Of which undetected, or with harm before the stop: {words_of(undetected)}"
    risk = mission.failure_probability
    text += f" ({share_text(undetected / risk)})" if has_share and risk > 0.0 else ""
    text += f"; of that stopped late: {words_of(late)}."
    return f"{text} Stopped safely: {words_of(safely)}."


_SEEN = 1e-4
"""How far readings differ, relative, where the digits shown may distinguish them."""


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
    if relative < _SEEN:
        if all(state.expected_visits <= 1.0 for state in assessment.states):
            return ""
        return f"However repeats are counted, it is the same: {', '.join(figures)}."
    text = "; ".join(f"{name} {_probability(value)}" for name, value in figures.items())
    text = f"{text[0].upper()}{text[1:]}: they differ by {100.0 * relative:.2g} %."
    if mission.reading == GEOMETRIC:
        return f"{text} The first holds: `next` is a distribution."
    return f"{text} The second holds: `next` counts the cycles of a mission."


def _fixed_cycles(mission: MissionFigures) -> str:
    if mission.expected_cycles is None or mission.expected_cycles < 1.5:
        # The mission is not its entry's rounds, or one of them: each loop has a number of its own.
        return "fixed cycles"
    return counted(mission.expected_cycles, "fixed cycle")


def _components(
    components: Sequence[ComponentImportance],
    width: int,
    title: str = "Components that matter most",
) -> Table:
    shown = components[:MOST_COMPONENTS]
    title = part_of(title, len(shown), len(components))
    table = table_of(title, ["component"])
    add_share_columns(table, width, heading="Fussell-Vesely" if width >= ROOMY else "share")
    measures: dict[str, Callable[[ComponentImportance], str]] = {
        "criticality": lambda importance: share_text(importance.criticality),
        "RRW": lambda importance: f"{importance.risk_reduction_worth:.4g}",
        "RAW": lambda importance: f"{importance.risk_achievement_worth:.3g}",
        "tenfold": lambda importance: f"{importance.tenfold:.4g}",
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
    from rich.text import Text

    if not lines:
        return
    console.print(Text(title, style="bold"))
    console.print(_list(lines))
    console.print()


def _list(lines: Sequence[str]) -> Table:
    """Return a list with dashes, each in a column of its own: the lines of an entry are flush."""
    from rich.table import Table

    grid = Table.grid(padding=(0, 1))
    for line in dict.fromkeys(lines):
        grid.add_row(*plain(["-", line]))
    return grid


def _probability(value: float) -> str:
    return f"{value:.2e}"
