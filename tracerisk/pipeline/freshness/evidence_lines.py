"""The places that evidence names: kept as lines without risk blocks, shown as they are now."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

from tracerisk.errors import InputError
from tracerisk.pipeline.trace.kept_verdict import bare_lines, block_lines

if TYPE_CHECKING:
    from tracerisk.common.evidence.cells import Evidence
    from tracerisk.pipeline.workspace.controller import Controller

_LineOf = Callable[[str, int], int]
_Lines = Callable[[Mapping[str, bytes], Mapping[str, str]], _LineOf]


def at_bare_line(place: str, controller: Controller) -> str:
    """Return a place, `file:line` of the sources that ran, as if these had no risk blocks.

    So evidence stays the same whatever the blocks say.
    """
    return _mover(controller, bare_lines)(place)


def at_lines_now(evidence: Evidence, controller: Controller) -> Evidence:
    """Return kept evidence with the places as they are in the sources, with their risk blocks."""
    moved = _mover(controller, block_lines)
    cells = tuple(replace(cell, missed_at=moved(cell.missed_at)) for cell in evidence.cells)
    return replace(evidence, cells=cells)


def _mover(controller: Controller, lines: _Lines) -> Callable[[str], str]:
    """Return what moves a place by the blocks of its file, which is read once."""

    @cache
    def line_of(file: str) -> _LineOf | None:
        path = controller.path_of(file)
        if not path.is_file():
            return None
        try:
            return lines({file: controller.source_of(file)}, {file: str(path)})
        except InputError:
            return None  # its blocks cannot be read

    def moved(place: str) -> str:
        file, _, line = place.rpartition(":")
        known = line_of(file) if file and line.isdigit() else None
        return place if known is None else f"{file}:{known(file, int(line))}"

    return moved
