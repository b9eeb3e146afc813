"""Two runs side by side: the earlier and the present one, in step, with what differs and where."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.common.hardware.binding import elements_by_component
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import EarlierRun, ReportInput, SideBySide, SourceFile
from tracerisk.report.html.run.in_step import Difference, InStep, in_step
from tracerisk.report.html.run.recorded_replay import make_replay
from tracerisk.report.html.run.replay import replay_data
from tracerisk.report.html.run.timeline import SPEEDS, timeline_data
from tracerisk.report.html.section import Data
from tracerisk.report.html.sources import line_links

if TYPE_CHECKING:
    from tracerisk.trace import TracedCommand

DATA = "side-by-side"
"""The id of the data within the page."""
MOST_FRAMES = 5_000
"""How many positions of the earlier run are drawn at most."""

_MOST_LISTED = 6  # differences in sight; more are folded
_MOST_CHANGED = 12  # places of the sources that are listed
_MOST_LINES = 12  # of one place
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


@dataclass(frozen=True, slots=True)
class _Change:
    """Lines of a source that differ between the versions."""

    file: str
    """File, as the traces name it."""
    function: str
    """Function of the lines; empty for none with a block."""
    line: int
    """The first line in the present version, or the one that follows."""
    before: str
    """File and first line of the earlier version, with its name."""
    now: str
    """File and first line of the present version."""
    link: str
    """Where in the page that is; empty for none."""
    gone: tuple[str, ...]
    """Lines of the earlier version."""
    come: tuple[str, ...]
    """Lines of the present version."""


def side_by_side(
    shown: SideBySide, report: ReportInput, renamed: Mapping[str, str]
) -> tuple[Markup, tuple[Data, ...]]:
    """Return what shows both runs of a report, and the data that its script reads.

    `renamed` gives the later name of functions by their earlier one. Raises HardwareError where the
    hardware description does not fit the earlier run.
    """
    assert report.trace is not None, "the present run is shown"
    before = shown.before
    links = line_links(report.sources)
    aligned = in_step(before.trace, report.trace, renamed=renamed)
    changed = list(_changes(before, shown.sources, links))
    differences = [
        {"words": difference.words, "lines": _lines(difference, shown, changed, links)}
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
        changed=changed[:_MOST_CHANGED],
        more_changed=max(len(changed) - _MOST_CHANGED, 0),
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
    shown: SideBySide,
    changed: Sequence[_Change],
    links: Mapping[tuple[str, int | None], str],
) -> list[_Place]:
    """Return the lines that a difference comes from.

    They are the changed line that led to the command, else those that were changed in the function
    that gave it, the nearest to it; where it was not changed, the command's own.
    """
    command = difference.now or difference.before
    if command is None:
        return []
    source = shown.sources.get(command.function.file)
    name = "" if source is None else _function_at(source, command.line)
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
    version = f"{shown.before.version}:"
    places = [
        _command_place("before", difference.before, shown.before.sources, {}, version),
        _command_place("now", difference.now, shown.sources, links, ""),
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


def _changes(
    earlier: EarlierRun,
    now: Mapping[str, SourceFile],
    links: Mapping[tuple[str, int | None], str],
) -> Iterator[_Change]:
    """Yield the lines that differ, risk blocks left out."""
    before = earlier.sources
    for file in dict.fromkeys((*now, *before)):
        old, new = _code(before.get(file)), _code(now.get(file))
        matcher = difflib.SequenceMatcher(
            None, [text for _, text in old], [text for _, text in new], autojunk=False
        )
        for kind, old_first, old_last, first, last in matcher.get_opcodes():
            gone, come = old[old_first:old_last], new[first:last]
            if kind == "equal" or not any(text.strip() for _, text in (*gone, *come)):
                continue
            line = new[min(first, len(new) - 1)][0] if new else 0
            was = old[min(old_first, len(old) - 1)][0] if old else 0
            name = now[file].name if file in now else ""
            yield _Change(
                file,
                _function_at(now.get(file), line),
                line,
                f"{earlier.version}:{before[file].name}:{was}" if file in before else "",
                f"{name}:{line}" if name else "",
                links.get((name, line), ""),
                _few(gone),
                _few(come),
            )


def _code(source: SourceFile | None) -> list[tuple[int, str]]:
    """Return the lines of a source outside risk blocks, with their numbers."""
    if source is None:
        return []
    blocks = {
        number for block in source.blocks for number in range(block.first_line, block.last_line + 1)
    }
    lines = enumerate(source.text.splitlines(), start=1)
    return [(number, text.rstrip()) for number, text in lines if number not in blocks]


def _function_at(source: SourceFile | None, line: int) -> str:
    """Return the function with a block whose definition stands last above a line."""
    above = [] if source is None else [block for block in source.blocks if block.line <= line]
    if source is None or not above:
        return ""
    block = max(above, key=lambda known: known.line)
    lines = source.text.splitlines()
    margin = _margin(lines[block.line - 1])
    between = [text for text in lines[block.line : line] if text.strip()]
    is_left = any(_margin(text) <= margin and text.strip()[0] not in ")]}#" for text in between)
    return "" if is_left else block.function


def _margin(text: str) -> int:
    return len(text) - len(text.lstrip())


def _few(lines: Sequence[tuple[int, str]]) -> tuple[str, ...]:
    texts = [text for _, text in lines]
    if len(texts) <= _MOST_LINES:
        return tuple(texts)
    return (*texts[:_MOST_LINES], f"... and {len(texts) - _MOST_LINES} lines more")
