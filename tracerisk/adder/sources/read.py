"""Find the risk blocks of a Python source and the functions they stand in."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from tracerisk.adder.blocks.grammar import HEADER_LINE, parse_block
from tracerisk.adder.blocks.lines import GUTTER, HEADER, BlockLine
from tracerisk.adder.sources.placed import MisplacedBlockError, Place, PlacedBlock, only_one_each
from tracerisk.adder.sources.python_lines import (
    BYTE_ORDER_MARK,
    PythonSource,
    comment_lines,
    docstring_end,
    header_end,
    parse_python,
)
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.instance_name import is_name_at
from tracerisk.errors import BlockError, Location
from tracerisk.instrument.source.function_definitions import (
    MODULE,
    Definition,
    definitions,
    first_line,
    normal_name,
)
from tracerisk.instrument.source.language import is_c_like

_GUTTER = re.compile(rb"[ \t\f]*#[ \t]?\|(?:[ \t].*)?")
_SECTION = re.compile(rb"[ \t\f]*#[ \t]?\|[ \t]+@(?:Function|Component)\b.*")
_HEADER = re.compile(rb"[ \t\f]*#[ \t]?\|[ \t]+" + HEADER_LINE.encode() + rb"[ \t]*")
_HEADER_WORD = HEADER.encode()
_ANY_BLOCK = re.compile(rb"#[ \t]?\|[ \t]+(?:RiskAnnotation|@Function|@Component|@Failure)")


class _Owner(NamedTuple):
    """A function that a block may belong to."""

    name: QualifiedName
    """The qualified name of the function."""
    line: int
    """The line of its `def`; of the first statement for module-level code."""
    place: Place
    """Where the block stands, seen from the function."""
    is_certain: bool = True
    """Whether the block is of this function whatever it says; else by the function's name in it."""


class _Run(NamedTuple):
    """Gutter lines without a gap, from the first `RiskAnnotation` on."""

    first: int
    """The first line, from 1."""
    last: int
    """The last line."""
    headers: tuple[int, ...]
    """The lines with `RiskAnnotation`, one a block."""


def read_blocks(source: bytes, file: str) -> tuple[PlacedBlock, ...]:
    """Return the risk blocks of a Python, C or C++ source in the order of the file.

    Block text inside strings is not a block.

    Raises:
        BlockError: if a block is malformed, misplaced or under another function than its
            `name` says, or two blocks describe one function.
        SourceError: if the source is not Python.
        DependencyError: if C or C++ is to be read and the extra `cpp` is not installed.
    """
    if is_c_like(file):
        from tracerisk.adder.sources.c_blocks import scan_c_blocks

        return only_one_each(scan_c_blocks(source, file), file)
    if _ANY_BLOCK.search(source) is None:
        return ()
    return only_one_each(scan_blocks(parse_python(source, file)), file)


def block_lines(source: bytes, file: str) -> tuple[int, ...]:
    """Return the lines that belong to risk blocks, ascending, whatever the blocks say.

    Raises SourceError if the source is not Python, DependencyError as `read_blocks`.
    """
    if is_c_like(file):
        from tracerisk.adder.sources.c_blocks import c_block_lines

        return c_block_lines(source, file)
    if _ANY_BLOCK.search(source) is None:
        return ()
    parsed = parse_python(source, file)
    finder = _OwnerFinder(parsed)
    runs = (run for run in _runs(parsed) if finder.owners(run))
    return tuple(line for run in runs for line in range(run.first, run.last + 1))


def scan_blocks(source: PythonSource) -> tuple[PlacedBlock, ...]:
    """Return the blocks of a parsed source; functions of one name may have one each.

    Raises:
        BlockError: as `read_blocks`.
    """
    if not any(b"|" in line and _ANY_BLOCK.search(line) for line in source.lines):
        return ()
    runs = tuple(_runs(source))
    finder = _OwnerFinder(source)
    placed_blocks: list[PlacedBlock] = []
    strays: list[int] = []
    for run in runs:
        owners = finder.owners(run)
        if owners:
            placed_blocks += _placed(source, run, owners)
        else:
            strays.append(run.first)
    in_runs = {number for run in runs for number in range(run.first, run.last + 1)}
    strays += [
        number
        for number, line in enumerate(source.lines, start=1)
        if b"@" in line and number not in in_runs and _SECTION.fullmatch(line.rstrip(b"\r\n"))
    ]
    if strays:
        _forbid_strays(source, strays)
    return tuple(placed_blocks)


def _forbid_strays(source: PythonSource, strays: Sequence[int]) -> None:
    comments = comment_lines(source)
    for number in sorted(strays):
        if number not in comments:
            continue
        location = Location(source.file, number)
        if _HEADER.fullmatch(_bare(source.lines[number - 1])):
            raise BlockError(
                "a risk block stands where no function begins; allowed: the first lines of a "
                "function's body, directly above a one-line function, or the top of a script",
                location,
            )
        raise BlockError(
            f"`{source.text(number).strip()}` is outside a risk block; a block begins with "
            f"`{GUTTER}{HEADER}`, and all its lines follow without a gap",
            location,
        )


def _bare(line: bytes) -> bytes:
    return line.rstrip(b"\r\n").removeprefix(BYTE_ORDER_MARK)


def _runs(source: PythonSource) -> Iterator[_Run]:
    first = 0
    headers: list[int] = []
    for number, line in enumerate((*source.lines, b""), start=1):
        bare = _bare(line) if b"|" in line else b""
        if bare and _GUTTER.fullmatch(bare):
            if _HEADER_WORD in bare and _HEADER.fullmatch(bare):
                first = first or number
                headers.append(number)
        elif first:
            yield _Run(first, number - 1, tuple(headers))
            first, headers = 0, []


class _OwnerFinder:
    """Finds which functions a block at some place may belong to."""

    def __init__(self, source: PythonSource) -> None:
        self._source = source
        self._definitions = tuple(definitions(source.tree))

    def owners(self, run: _Run) -> tuple[_Owner, ...]:
        owners: list[_Owner] = []
        for definition in self._definitions:
            if definition.line < run.first and run.last < definition.body_line:
                end = header_end(self._source, definition)
                if end is not None and end < run.first:
                    owners.append(_Owner(definition.name, definition.line, "body"))
        module = self._module(run)
        if module is not None:
            owners.append(module)
        below = self._below(run)
        if below is not None:
            is_on_one_line = below.line == below.body_line
            is_within = any(owner.place == "body" for owner in owners)
            is_certain = below.line == run.last + 1 or (is_on_one_line and not is_within)
            owners.append(_Owner(below.name, below.line, "above", is_certain))
        return tuple(owners)

    def _below(self, run: _Run) -> Definition | None:
        """Return the function before whose `def` only blank lines and comments are, or decorators.

        Formatters put blank lines between a block above a function and its `def`.
        """
        below = [one for one in self._definitions if one.line > run.last]
        if not below:
            return None
        nearest = min(below, key=lambda one: one.line)
        if nearest.line == run.last + 1:
            return nearest
        is_apart = any(map(self._is_code, range(run.last + 1, nearest.first_line)))
        # Text in a string may look like a block too.
        return None if is_apart or run.first not in comment_lines(self._source) else nearest

    def _is_code(self, number: int) -> bool:
        line = _bare(self._source.lines[number - 1]).lstrip(b" \t\f")
        return bool(line) and not line.startswith(b"#")

    def _module(self, run: _Run) -> _Owner | None:
        body = self._source.tree.body
        if not body:
            return _Owner(MODULE, 1, "module")
        start = first_line(body[0])
        if run.last < start:
            return _Owner(MODULE, start, "module")
        end = docstring_end(self._source)
        if end is None or run.first <= end:
            return None
        if len(body) > 1 and run.last >= first_line(body[1]):
            return None
        return _Owner(MODULE, start, "module")


def _placed(source: PythonSource, run: _Run, owners: tuple[_Owner, ...]) -> Iterator[PlacedBlock]:
    for start, after in zip(run.headers, (*run.headers[1:], run.last + 1), strict=True):
        lines = [
            BlockLine(number, _behind_gutter(source.text(number))) for number in range(start, after)
        ]
        block = parse_block(lines, source.file)
        name = QualifiedName(normal_name(block.name))
        named = [owner for owner in owners if is_name_at(name, owner.name)]
        if not named:
            functions = [owner.name for owner in owners if owner.is_certain]
            if not any(owner.is_certain for owner in owners):
                _forbid_strays(source, [start])
            raise MisplacedBlockError(block, name, functions, Location(source.file, start))
        owner = named[0]
        yield PlacedBlock(block, name, owner.line, owner.place, start, after - 1)


def _behind_gutter(line: str) -> str:
    return line.partition("|")[2]
