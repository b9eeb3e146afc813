"""The figures that an editor shows above the functions of a source."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.verdict import verdict_line
from tracerisk.editor.figures import ControllerFigures
from tracerisk.editor.outline import Outline
from tracerisk.report.tables import counted, share_text


@dataclass(frozen=True, slots=True)
class Lens:
    """A line of text that the editor shows above a line of a source."""

    line: int
    """The line of the source, from 1."""
    text: str
    """The text to show."""
    refreshes: ControllerFigures | None = None
    """The controller that a click refreshes; `None` for text without an action."""


def lenses(
    outline: Outline,
    figures: Sequence[ControllerFigures],
    files: Sequence[str],
    stale: Sequence[bool],
) -> Iterator[Lens]:
    """Yield the lenses of a source; `files` are its names in each of the controllers.

    `stale` says for each controller whether a refresh would mend something.
    """
    is_one = len(figures) == 1
    for figure, file, is_stale in zip(figures, files, stale, strict=True):
        if file == figure.controller.file:
            yield from _of_mission(figure)
            if is_stale:
                yield Lens(1, "refresh risk blocks", figure)
        of = "" if is_one else f" in {figure.controller.file}"
        for placed in outline.placed:
            state = figure.state(file, placed.function)
            if state is None:
                continue
            ran = figure.run(state.name)
            exposed = "" if ran is None else f", {counted(ran[0], 'visit')}, {ran[1]:.1f} s"
            yield Lens(
                max(placed.line, 1),
                f"{share_text(figure.share(state))} of the mission's failure probability{of}: "
                f"{state.absorption_probability:.3g}{exposed}",
            )
        for name, line in outline.functions:
            if FunctionRef(file, name) in figure.never_ran:
                yield Lens(line, f"no risk data{of}: can command hardware and never ran")


def _of_mission(figures: ControllerFigures) -> Iterator[Lens]:
    if figures.assessment is not None:
        mission = figures.assessment.mission
        text = f"mission fails by its hardware with {mission.failure_probability:.4g}"
        yield Lens(1, f"{text}; {verdict_line(figures.verdict)}")
