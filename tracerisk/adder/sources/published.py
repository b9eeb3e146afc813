"""Read risk blocks in the published form, which stand in plain comments.

    /***                          # RiskAnnotation
     * RiskAnnotation             # @Function {
     * @Function {                #   name = place
     *   name = place             #   callSequence = 5
     *   callSequence = 5         # }
     * }
     ***/

The comment of C, C++ and Java on the left, of Python on the right; the line `RiskAnnotation` may
be missing, but for a block in the compact form, which reaches to the end of its comment.
Form: Grimmeisen, Golwalkar, Ma, Morozov (2024).
The name that a block gives is that of its function. In C and C++ `c_blocks.py` writes them too;
in Python they are read, never written.
The published method takes redundant units as good at the start of each visit, and so do these
blocks where they do not say when a failure is detected, and no digest says that they are ours.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.compact import is_function_line
from tracerisk.adder.blocks.grammar import HEADER_LINE, form_of, is_header, parse_block
from tracerisk.adder.blocks.lines import HEADER, BlockLine
from tracerisk.adder.sources.python_lines import comment_lines, parse_python
from tracerisk.errors import BlockError, Location
from tracerisk.instrument.source.c_tokens import tokens
from tracerisk.instrument.source.language import is_c

_C_LEAD = re.compile(r"[ \t]*\*+[ \t]?|[ \t]+")
# A frame on the right; the star of `operator*` is none.
_C_TRAIL = re.compile(r"(?:(?:\A|(?<=[ \t]))\*+)?[ \t]*\Z")
_PLAIN = re.compile(r"[ \t\f]*#(?![ \t]?\|)[ \t]?(?P<text>.*)")
# Decided by the bytes: most sources have blocks behind the gutter only, and are not read twice.
_PLAIN_BLOCK = re.compile(
    rb"(?:\A(?:\xef\xbb\xbf)?|[\r\n])[ \t\f]*#(?![ \t]?\|)[^\r\n]*(?:@Function|RiskAnnotation)"
)
_HEADER = HEADER.encode()
_BEGINS = re.compile(rf"\s*(?:{HEADER_LINE}|@(?:Function|Component)\b.*)\s*")


class CComment(NamedTuple):
    """A comment of C, C++ or Java with risk blocks."""

    start: int
    """The offset of its first byte in the source."""
    end: int
    """The offset of the byte after it."""
    line: int
    """The line on which it begins, from 1."""
    blocks: tuple[RiskBlock, ...]
    """The risk blocks in it."""


def c_comments(source: bytes, file: str) -> Iterator[CComment]:
    """Yield the comments of a C, C++ or Java source that hold blocks, in the order of the file.

    Raises:
        BlockError: a block is malformed, or a comment with one is not closed; with the line.
    """
    for token in tokens(source, is_java=not is_c(file)):
        text = source[token.start + 2 : token.end - 2 * token.is_closed]
        if not source.startswith(b"/*", token.start) or not (b"@" in text or _HEADER in text):
            continue
        line = source.count(b"\n", 0, token.start) + 1
        lines = text.decode("utf-8", errors="surrogateescape").replace("\r\n", "\n")
        if token.is_closed:
            blocks = tuple(_blocks_of(_c_lines(lines, line), file))
            if blocks:
                yield CComment(token.start, token.end, line, blocks)
        elif _begins_somewhere(lines):
            raise BlockError("the comment with this risk block has no `*/`", Location(file, line))


def read_c_blocks(source: bytes, file: str) -> tuple[RiskBlock, ...]:
    """Return the blocks in the comments of a C, C++ or Java source, in the order of the file.

    Raises as `c_comments`.
    """
    return tuple(block for comment in c_comments(source, file) for block in comment.blocks)


def read_plain_blocks(source: bytes, file: str) -> tuple[RiskBlock, ...]:
    """Return the blocks in plain `#` comments of a Python source, in the order of the file.

    Those behind the gutter `# | ` are not among them.

    Raises:
        BlockError: a block is malformed; with the line.
        SourceError: the source is not Python.
    """
    if _PLAIN_BLOCK.search(source) is None:
        return ()
    parsed = parse_python(source, file)
    comments = comment_lines(parsed)
    blocks: list[RiskBlock] = []
    run: list[BlockLine] = []
    for number in range(1, len(parsed.lines) + 2):
        matched = (
            _PLAIN.fullmatch(parsed.text(number).rstrip("\r\n")) if number in comments else None
        )
        if matched is not None:
            run.append(BlockLine(number, matched["text"]))
        elif run:
            blocks += _blocks_of(run, file)
            run = []
    return tuple(blocks)


def _c_lines(comment: str, first: int) -> list[BlockLine]:
    return [
        BlockLine(number, _C_TRAIL.sub("", _C_LEAD.sub("", line, count=1), count=1).rstrip(" \t"))
        for number, line in enumerate(comment.split("\n"), start=first)
    ]


def _begins_somewhere(comment: str) -> bool:
    return any(_BEGINS.fullmatch(line.text) for line in _c_lines(comment, 1))


def _blocks_of(lines: Sequence[BlockLine], file: str) -> Iterator[RiskBlock]:
    """Yield the blocks of one comment; a comment without one is none of ours."""
    at = next((i for i, line in enumerate(lines) if _BEGINS.fullmatch(line.text)), None)
    if at is None:
        return
    for part in _parts(lines[at:]):
        if not is_header(part[0].text):
            part.insert(0, BlockLine(part[0].number, HEADER))
        if _is_prose(part):
            continue
        yield _in_the_published_reading(parse_block(part, file))


def _is_prose(part: Sequence[BlockLine]) -> bool:
    """Return whether a comment speaks of a block only: under the word, without a digest."""
    texts = [text for line in part[1:] if (text := line.text.strip())]
    return (
        part[0].text.strip() == HEADER
        and (not texts or (form_of(part[1:]) == "compact" and not is_function_line(texts[0])))
        and not any(text.startswith(("@Function", "@Component", "@Failure")) for text in texts)
    )


def _in_the_published_reading(block: RiskBlock) -> RiskBlock:
    if block.digest is not None:
        return block
    return replace(block, components=tuple(map(_renewed, block.components)))


def _renewed(entry: ComponentEntry) -> ComponentEntry:
    stated = entry.redundancy
    if not stated.value or "detected" in stated.text:
        return entry
    value = replace(stated.value, detected="each_visit")
    return replace(entry, redundancy=replace(stated, value=value))


def _parts(lines: Iterable[BlockLine]) -> list[list[BlockLine]]:
    """Cut where another block begins: at each header, or at a second `@Function`."""
    parts: list[list[BlockLine]] = [[]]
    for line in lines:
        text = line.text.strip()
        begins = is_header(text) or (
            text.startswith("@Function")
            and any(block_line.text.strip().startswith("@Function") for block_line in parts[-1])
        )
        if begins and parts[-1]:
            parts.append([])
        parts[-1].append(line)
    return [_to_last_brace(part) for part in parts]


def _to_last_brace(part: list[BlockLine]) -> list[BlockLine]:
    """Leave out what else the comment says below a block of the published form."""
    if is_header(part[0].text) and form_of(part[1:]) == "compact":
        return part
    closing = [index for index, line in enumerate(part) if line.text.strip() == "}"]
    if not closing or any(line.text.strip().startswith("@") for line in part[closing[-1] + 1 :]):
        return part
    return part[: closing[-1] + 1]
