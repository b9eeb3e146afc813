"""The annotated sources, line by line, with their blocks, and the lines that a change changed."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import (
    ComparedSources,
    ReportInput,
    SourceBlock,
    SourceFile,
)
from tracerisk.report.html.section import Section
from tracerisk.report.html.tokens import Token, tokens_of

_MOST_LINES = 12  # of one changed place


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


@dataclass(frozen=True, slots=True)
class ChangedLines:
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


def changed_lines(
    sources: ComparedSources, links: Mapping[tuple[str, int | None], str]
) -> Iterator[ChangedLines]:
    """Yield the lines that differ between two versions, risk blocks left out.

    `links` lead to the present lines, by file and line.
    """
    before, now = sources.before, sources.now
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
            yield ChangedLines(
                file,
                function_at(now.get(file), line),
                line,
                f"{sources.prefix}{before[file].name}:{was}" if file in before else "",
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


def function_at(source: SourceFile | None, line: int) -> str:
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
