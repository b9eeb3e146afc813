"""The text of a risk annotation block: parse it, report each mistake with its line, and print it.

A block is comment lines after the gutter `# | `, which no linter takes for dead code: a header,
then the published form (`sections.py`) or the compact one (`compact.py`).
Here a line is what follows the gutter; finding blocks in a file is the job of `sources/read.py`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.compact import read_compact
from tracerisk.adder.blocks.compact_print import print_compact
from tracerisk.adder.blocks.conflicts import is_conflict_marker
from tracerisk.adder.blocks.failures import goes_on
from tracerisk.adder.blocks.lines import DEFAULT_WIDTH, GUTTER, HEADER, BlockLine
from tracerisk.adder.blocks.sections import print_sections, read_sections
from tracerisk.config import BlockForm
from tracerisk.errors import BlockError, Location

DIGEST = "[0-9A-Za-z]{6}(?:-[0-9A-Za-z]{6}(?:[0-9A-Za-z]{2})?)*"
"""What may follow the header: see `adder/lock/digest.py`."""

WITH_EVIDENCE = "with evidence"
"""What follows the header of a block whose values take evidence into account."""

HEADER_LINE = rf"{HEADER}(?:[ \t]+(?P<digest>{DIGEST}))?(?P<evidence>[ \t]+{WITH_EVIDENCE})?"
"""The line with which a block begins, as a regular expression."""

_HEADER = re.compile(HEADER_LINE)
# Lines of the published form, some of them out of their place.
_OF_SECTIONS = re.compile(
    r"[@!}].*|(?:name|callSequence|next|probability|quantity|redundancy)\s*=.*"
)
# What goes on with no mode, as a conflict marker.
_OTHER = re.compile(r"->|[@!}<>=|]|\w+\s*:?=")
_READ = {"published": read_sections, "compact": read_compact}
_PRINTED = {"published": print_sections, "compact": print_compact}


def is_header(text: str) -> bool:
    """Return whether a line begins a block, with a digest or without."""
    return _HEADER.fullmatch(text.strip()) is not None


def form_of(lines: Sequence[BlockLine]) -> BlockForm:
    """Return the form of a block, given the lines behind its header."""
    first = next((text for line in lines if (text := line.text.strip())), "@")
    is_compact = _OF_SECTIONS.fullmatch(first) is None and not is_conflict_marker(first)
    return "compact" if is_compact else "published"


def parse_block(lines: Sequence[BlockLine], file: str) -> RiskBlock:
    """Return the block that `lines` state, from its `RiskAnnotation` line to its last one.

    Raises:
        BlockError: if a line is unknown or malformed, a brace or a value is missing, or a name
            is given twice; with the file and the line.
    """
    header = _HEADER.fullmatch(lines[0].text.strip()) if lines else None
    if header is None:
        number = lines[0].number if lines else 1
        raise BlockError(
            f"a risk block begins with the line `{GUTTER}{HEADER}`", Location(file, number)
        )
    said = _with_whole_modes(lines[1:])
    form = form_of(said)
    block = _READ[form](lines[0].number, said, file)
    seen: dict[str, Location | None] = {}
    for component in block.components:
        if component.name in seen:
            first = seen[component.name]
            raise BlockError(
                f"duplicate component {component.name} in this block, first at line "
                f"{first and first.line}; delete one",
                component.location,
            )
        seen[component.name] = component.location
    return replace(
        block, digest=header["digest"], has_evidence=header["evidence"] is not None, form=form
    )


def _with_whole_modes(lines: Iterable[BlockLine]) -> list[BlockLine]:
    """Return lines of which each that goes on with a mode stands behind the one before."""
    whole: list[BlockLine] = []
    is_open = False
    for line in lines:
        text = line.text.strip()
        is_further = is_open and _OTHER.match(text) is None
        if is_further:
            whole[-1] = whole[-1]._replace(text=f"{whole[-1].text.rstrip()} {text}")
        elif text:
            whole.append(line)
        is_open = goes_on(text, is_open=is_further) if text else is_open
    return whole


def print_block(block: RiskBlock, width: int = DEFAULT_WIDTH) -> tuple[str, ...]:
    """Return the lines of a block in its form, gutter included, without indentation and line ends.

    `width` is the room for a line; reasons and what follows failures are wrapped to it.
    Parsed again, the lines give the same block.
    """
    marks = [block.digest or "", WITH_EVIDENCE if block.has_evidence else ""]
    header = " ".join([HEADER, *(mark for mark in marks if mark)])
    return tuple(GUTTER + line for line in (header, *_lines(block, width)))


def _lines(block: RiskBlock, width: int) -> list[str]:
    """Return the lines behind the header.

    Of a block that is converted, reasons are wrapped anew only if they were wrapped before: it
    comes back from the other form as it was typed. Where typed lines look wrapped in the other
    form, a `!` alone behind them says that they are not.
    """
    wrapped = block.with_comment_lines(lambda _: ())
    if block.moved_from is None or _printed(block, width, block.moved_from) == _printed(
        wrapped, width, block.moved_from
    ):
        return _printed(wrapped, width, block.form)
    typed = block.with_comment_lines(lambda lines: lines[:-1] if lines[-1:] == ("",) else lines)
    lines = _printed(typed, width, block.form)
    if lines != _printed(wrapped, width, block.form):
        return lines
    marked = typed.with_comment_lines(lambda lines: (*lines, "") if lines else ())
    return _printed(marked, width, block.form)


def _printed(block: RiskBlock, width: int, form: BlockForm) -> list[str]:
    return _PRINTED[form](block, width)
