"""What an editor shows beside a function or a block: its figure, its share, and why."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from tracerisk.adder.blocks.block import ComponentEntry, Field
from tracerisk.adder.blocks.values import component_fields
from tracerisk.adder.sources.placed import PlacedBlock
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.verdict import verdict_line
from tracerisk.editor.figures import ControllerFigures, UnitUse
from tracerisk.editor.outline import Outline
from tracerisk.prm.hybrid.assessment import StateAssessment
from tracerisk.report.functions_table import units_needed
from tracerisk.report.tables import counted, share_text

MOST_COMPONENTS = 6
"""How many components of a function are shown, those that matter most first."""
_WORD = re.compile(r"[^\W\d]\w*")


def function_at(outline: Outline, line: int, text: str, index: int) -> QualifiedName | None:
    """Return the function that a place of a source speaks of, of those with a block.

    `line` counts from 1; `text` is the line, `index` the character in it. That is the function
    whose block or definition is there, or the one whose name is.
    """
    block = outline.block_at(line)
    if block is not None:
        return block.function
    word = next(
        (
            match_.group()
            for match_ in _WORD.finditer(text)
            if match_.start() <= index <= match_.end()
        ),
        None,
    )
    named = [
        placed_block for placed_block in outline.placed if _last_name(placed_block.function) == word
    ]
    here = [placed_block for placed_block in named if placed_block.line == line]
    if here or len(named) == 1:
        return (here or named)[0].function
    return None


def _last_name(function: QualifiedName) -> str:
    return function.partition(" (")[0].rpartition(".")[2]


def component_at(block: PlacedBlock, line: int) -> ComponentEntry | None:
    """Return the component whose section holds a line of a block."""
    components = [
        component
        for component in block.block.components
        if component.location is not None and (component.location.line or line + 1) <= line
    ]
    return components[-1] if components else None


def function_markdown(
    figures: Sequence[ControllerFigures], file: Sequence[str], function: QualifiedName
) -> str:
    """Return what is known of a function, for each of the controllers that it is part of.

    `file` is the source, as each of the controllers names it. Empty where nothing is known.
    """
    lines = []
    for figure, name in zip(figures, file, strict=True):
        state = figure.state(name, function)
        if state is not None:
            lines.append("\n".join(_function_lines(figure, state)))
    return "\n\n---\n\n".join(lines)


def _function_lines(figures: ControllerFigures, state: StateAssessment) -> Iterator[str]:
    assessment = figures.assessment
    assert assessment is not None
    mission = assessment.mission
    yield (
        f"**{_plain(state.name)}**: {share_text(figures.share(state))} of the mission's failure "
        f"probability ({state.absorption_probability:.3g} of {mission.geometric_cycles:.3g})"
    )
    yield ""
    ran = figures.run(state.name)
    visits = f"{counted(state.expected_visits, 'visit')} expected in a mission"
    exposed = "" if ran is None else f"; the last run: {counted(ran[0], 'visit')}, {ran[1]:.1f} s"
    yield f"One visit fails with {state.top_event:.3g}; {visits}{exposed}."
    yield ""
    yield from _components(figures, state)
    yield from closing_lines(figures)


def _components(figures: ControllerFigures, state: StateAssessment) -> Iterator[str]:
    ranked = sorted(state.components, key=lambda component: -component.contribution)
    if not ranked:
        yield "No component is active in it."
        yield ""
        return
    yield "| component | needed | unit fails in a visit | most used unit | part of it |"
    yield "|---|---|---|---|---|"
    for contribution in ranked[:MOST_COMPONENTS]:
        part = contribution.contribution / state.top_event if state.top_event > 0.0 else 0.0
        use = figures.use(state.name, contribution.component)
        cells = (
            _plain(contribution.name),
            units_needed(contribution),
            f"{contribution.probability:.3g}",
            "-" if use is None else use_text(use),
            share_text(part),
        )
        yield f"| {' | '.join(cells)} |"
    if len(ranked) > MOST_COMPONENTS:
        yield f"| and {len(ranked) - MOST_COMPONENTS} more | | | | |"
    yield ""


def use_text(use: UnitUse) -> str:
    """Return what a unit did, in words."""
    times = (
        ("moving", use.moving_s),
        ("holding", use.holding_s),
        ("grasping", use.grasping_s),
        ("read", use.reading_s),
    )
    text = ", ".join(f"{what} {seconds:.1f} s" for what, seconds in times if seconds)
    return f"{_plain(use.unit)}: {text or 'not in use'}"


def closing_lines(figures: ControllerFigures) -> Iterator[str]:
    """Yield what stands below every figure: the mission's, the verdict, what the figure is."""
    assessment = figures.assessment
    assert assessment is not None
    mission = assessment.mission
    name = _plain(figures.controller.file)
    yield (
        f"Mission of {name}: {mission.failure_probability:.4g} ({mission.reading}); "
        f"{_plain(verdict_line(figures.verdict))}."
    )
    if figures.problem is not None:
        yield f"Not all of it could be read: {_plain(figures.problem.message)}"
    yield ""
    yield f"*{_plain(assessment.statement)}*"


def component_markdown(
    figures: Sequence[ControllerFigures],
    file: Sequence[str],
    block: PlacedBlock,
    entry: ComponentEntry,
) -> str:
    """Return what is known of one component of a block."""
    lines = [f"**{_plain(entry.name)}** in {_plain(block.function)}{_by_hand(entry)}", ""]
    for kind, value in component_fields(entry):
        if value.is_stated:
            lines.append(f"- {kind.key}: {_plain(value.text)}{_said(value)}")
    lines.append("")
    for figure, name in zip(figures, file, strict=True):
        state = figure.state(name, block.function)
        if state is None or figure.assessment is None:
            continue
        contributions = [one for one in state.components if one.component == entry.name]
        contribution = sum(one.contribution for one in contributions)
        part = contribution / state.top_event if state.top_event > 0.0 else 0.0
        lines.append(
            f"{share_text(part)} of the failure probability of {_plain(state.name)}, "
            f"{share_text(part * figure.share(state))} of that of the mission."
        )
        use = figure.use(state.name, entry.name)
        if use is not None:
            lines.append(f"Most used unit in the last run: {use_text(use)}.")
        lines += [
            "If it never failed, the mission's failure probability would fall by "
            f"{share_text(one.fussell_vesely)}."
            for one in figure.importances
            if one.component == entry.name
        ]
        lines += ["", *closing_lines(figure)]
    return "\n".join(lines)


def _by_hand(entry: ComponentEntry) -> str:
    if not (entry.added or entry.omitted):
        return ""
    what = "left out" if entry.omitted else "added"
    return f", {what} by hand: {_plain(entry.reason or 'no reason given')}"


def _said(value: Field[object]) -> str:
    if not value.pinned:
        return ""
    computed = "" if value.computed is None else f"; computed: {_plain(value.computed)}"
    return f", set by hand: {_plain(value.reason or 'no reason given')}{computed}"


def _plain(text: str) -> str:
    """Return text that Markdown shows as it is, on one line."""
    return re.sub(r"([\\`*_\[\]<>|#])", r"\\\1", " ".join(text.split()))
