"""Two runs side by side: the earlier and the present one, in step, with what differs and where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.common.hardware.binding import elements_by_component
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import (
    ComparedSources,
    ReportInput,
    SideBySide,
    SourceFile,
)
from tracerisk.report.html.run.in_step import Difference, InStep, in_step
from tracerisk.report.html.run.recorded_replay import make_replay
from tracerisk.report.html.run.replay import replay_data
from tracerisk.report.html.run.timeline import SPEEDS, timeline_data
from tracerisk.report.html.section import Data
from tracerisk.report.html.sources import ChangedLines, function_at, line_links

if TYPE_CHECKING:
    from tracerisk.trace import TracedCommand

DATA = "side-by-side"
"""The id of the data within the page."""
MOST_FRAMES = 5_000
"""How many positions of the earlier run are drawn at most."""

_MOST_LISTED = 6  # differences in sight; more are folded
_KINDS = (
    ("other", "both, differently"),
    ("before", "only before"),
    ("now", "only now"),
    ("mark", "a difference"),
)


@dataclass(frozen=True, slots=True)
class _Place:
    """A line of a source."""

    side: str
    """Of which version it is."""
    where: str
    """File and line, with the version for the earlier one."""
    text: str
    """What stands in the line."""
    link: str
    """Where in the page it is; empty for the earlier version."""


def side_by_side(
    shown: SideBySide,
    report: ReportInput,
    changed: Sequence[ChangedLines],
    renamed: Mapping[str, str],
) -> tuple[Markup, tuple[Data, ...]]:
    """Return what shows both runs of a report, and the data that its script reads.

    `changed` are the lines of the sources that differ; `renamed` gives the later name of functions
    by their earlier one. Raises HardwareError where the hardware description does not fit the
    earlier run.
    """
    assert report.trace is not None, "the present run is shown"
    sources = report.compared_sources
    assert sources is not None, "they come with the runs"
    before = shown.before
    links = line_links(report.sources)
    aligned = in_step(before.trace, report.trace, renamed=renamed)
    differences = [
        {"words": difference.words, "lines": _lines(difference, sources, changed, links)}
        for difference in aligned.differences
    ]
    html = rendered(
        "side_by_side.html.j2",
        before=before.version,
        now="" if report.review is None else report.review.after,
        speeds=SPEEDS,
        kinds=_KINDS,
        differences=differences,
        most=_MOST_LISTED,
    )
    replay = make_replay(before.recorded, before.trace.end.simulated_s, most_frames=MOST_FRAMES)
    names = model_names([function.ref for function in before.trace.functions])
    components = (
        {}
        if report.hardware is None
        else elements_by_component(report.hardware, before.trace.elements)
    )
    data = {
        "before": timeline_data(before.trace, components, names, replay),
        **_axis(aligned),
    }
    return html, (Data.of_json(DATA, data), *replay_data(replay, "side-before"))


def _axis(aligned: InStep) -> dict[str, Any]:
    """Return the common axis as the script reads it; times are in [s]."""
    return {
        "stretches": [
            {
                "kind": stretch.kind,
                "before": [round(time, 3) for time in stretch.before],
                "now": [round(time, 3) for time in stretch.now],
            }
            for stretch in aligned.stretches
        ],
        "differences": [
            {"before": round(difference.before_s, 3), "now": round(difference.now_s, 3)}
            for difference in aligned.differences
        ],
    }


def _lines(
    difference: Difference,
    sources: ComparedSources,
    changed: Sequence[ChangedLines],
    links: Mapping[tuple[str, int | None], str],
) -> list[_Place]:
    """Return the lines that a difference comes from.

    They are the changed line that led to the command, else those that were changed in the function
    that gave it, the nearest to it; where it was not changed, the command's own.
    """
    command = difference.now or difference.before
    if command is None:
        return []
    source = sources.now.get(command.function.file)
    name = "" if source is None else function_at(source, command.line)
    own = [
        change
        for change in changed
        if (change.file, change.function) == (command.function.file, name)
    ]
    called = [
        change
        for caller in command.callers
        for change in changed
        if change.file == caller.file
        and change.line <= (caller.line or 0) < change.line + len(change.come)
    ]
    if called or (name and own):
        nearest = sorted(own, key=lambda known: abs(known.line - command.line))
        change = (called or nearest)[0]
        return [
            *(_Place("before", change.before, text.strip(), "") for text in change.gone[:1]),
            *(_Place("now", change.now, text.strip(), change.link) for text in change.come[:1]),
        ]
    places = [
        _command_place("before", difference.before, sources.before, {}, sources.prefix),
        _command_place("now", difference.now, sources.now, links, ""),
    ]
    known = [place for place in places if place is not None]
    # A command that stands there unchanged is shown once.
    return known[1:] if len({place.text for place in known}) == 1 < len(known) else known


def _command_place(
    side: str,
    command: TracedCommand | None,
    sources: Mapping[str, SourceFile],
    links: Mapping[tuple[str, int | None], str],
    prefix: str,
) -> _Place | None:
    """Return the line of a command; `None` where the source is not known."""
    source = None if command is None else sources.get(command.function.file)
    if command is None or source is None:
        return None
    lines = source.text.splitlines()
    if not 0 < command.line <= len(lines):
        return None
    link = links.get((source.name, command.line), "")
    where = f"{prefix}{source.name}:{command.line}"
    if command.callers:
        where += f", called from line {command.callers[0].line}"
    return _Place(side, where, lines[command.line - 1].strip(), link)
