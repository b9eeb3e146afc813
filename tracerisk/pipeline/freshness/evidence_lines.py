"""The places that evidence names: kept as lines without risk blocks, shown as they are now."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from tracerisk.errors import InputError
from tracerisk.pipeline.trace.kept_verdict import bare_lines, block_lines

if TYPE_CHECKING:
    from tracerisk.common.evidence.cells import Evidence
    from tracerisk.pipeline.workspace.controller import Controller

_Lines = Callable[[Mapping[str, bytes], Mapping[str, str]], Callable[[str, int], int]]


def at_bare_line(place: str, controller: Controller) -> str:
    """Return a place, `file:line` of the sources that ran, as if these had no risk blocks.

    So evidence stays the same whatever the blocks say.
    """
    return _moved(place, controller, bare_lines)


def at_lines_now(evidence: Evidence, controller: Controller) -> Evidence:
    """Return kept evidence with the places as they are in the sources, with their risk blocks."""
    places = {cell.missed_at for cell in evidence.cells}
    now = {place: _moved(place, controller, block_lines) for place in places}
    cells = tuple(replace(cell, missed_at=now[cell.missed_at]) for cell in evidence.cells)
    return replace(evidence, cells=cells)


def _moved(place: str, controller: Controller, lines: _Lines) -> str:
    file, _, line = place.rpartition(":")
    if not file or not line.isdigit() or not controller.path_of(file).is_file():
        return place
    try:
        sources, shown = {file: controller.source_of(file)}, {file: str(controller.path_of(file))}
        return f"{file}:{lines(sources, shown)(file, int(line))}"
    except InputError:
        return place  # of a file whose blocks cannot be read
