"""The annotated sources, line by line, with their blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput, SourceBlock, SourceFile
from tracerisk.report.html.section import Section
from tracerisk.report.html.tokens import Token, tokens_of


@dataclass(frozen=True, slots=True)
class SourceLine:
    """A line of a source as the page shows it."""

    number: int
    """Line number, from 1."""
    name: str
    """Id of the line in the page."""
    tokens: tuple[Token, ...]
    """Words of the line by kind, in order."""
    function: str | None
    """Function whose block or definition it belongs to; `None` for neither."""
    is_block: bool
    """Whether the line is part of a block."""


@dataclass(frozen=True, slots=True)
class ShownSource:
    """A source as the page shows it."""

    file: SourceFile
    """The source."""
    lines: tuple[SourceLine, ...]
    """Its lines in order."""
    links: tuple[tuple[str, str], ...]
    """Links to its blocks, ((function, target), ...)."""


def sources_section(report: ReportInput) -> Section | None:
    """Return the sources, folded; `None` where there are none."""
    if not report.sources:
        return None
    html = rendered("sources.html.j2", sources=shown_sources(report.sources))
    return Section("source", "Annotated source", html)


def shown_sources(sources: Sequence[SourceFile]) -> tuple[ShownSource, ...]:
    """Return the lines of the sources, and where their blocks are."""
    return tuple(
        ShownSource(
            file,
            tuple(_lines(index, file)),
            tuple((block.function, f"#{_id(index, block.first_line)}") for block in file.blocks),
        )
        for index, file in enumerate(sources)
    )


def definitions(sources: Sequence[SourceFile]) -> dict[str, tuple[str, int]]:
    """Return the link to the definition of each function that has a block, and its line."""
    return {
        block.function: (f"#{_id(index, block.line)}", block.line)
        for index, file in enumerate(sources)
        for block in file.blocks
    }


def block_links(sources: Sequence[SourceFile]) -> dict[str, list[str]]:
    """Return the link to the block of each function, and what to call its place."""
    return {
        block.function: [f"#{_id(index, block.first_line)}", f"{file.name}:{block.first_line}"]
        for index, file in enumerate(sources)
        for block in file.blocks
    }


def line_links(sources: Sequence[SourceFile]) -> dict[tuple[str, int | None], str]:
    """Return the link to each line of the sources, by file and line."""
    return {
        (file.name, line): f"#{_id(index, line)}"
        for index, file in enumerate(sources)
        for line in range(1, len(_split(file.text)) + 1)
    }


def _lines(index: int, file: SourceFile) -> Iterator[SourceLine]:
    blocks: dict[int, SourceBlock] = {}
    definitions = {block.line: block.function for block in file.blocks}
    for block in file.blocks:
        blocks |= dict.fromkeys(range(block.first_line, block.last_line + 1), block)
    for number, tokens in enumerate(tokens_of(file.name, _split(file.text)), start=1):
        block_here = blocks.get(number)
        yield SourceLine(
            number,
            _id(index, number),
            tokens,
            block_here.function if block_here is not None else definitions.get(number),
            block_here is not None,
        )


def _split(text: str) -> list[str]:
    """Return the lines as Python counts them: a form feed or U+2028 ends none."""
    lines = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return lines[:-1] if lines and not lines[-1] else lines


def _id(index: int, line: int) -> str:
    return f"source-{index + 1}-{line}"
