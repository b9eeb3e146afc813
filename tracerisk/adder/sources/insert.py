"""Put risk blocks into a source and take them out, with no other byte changed.

In C and C++ `c_blocks.py` does so; what follows is of Python.
Edits are lines put into or cut out of the original bytes, at the places that libcst's
positions give. Each result is checked before it is handed out: without its blocks it is the
source without its blocks, byte for byte; its syntax tree is the same; and its blocks read
back as they were meant.
"""

from __future__ import annotations

from collections.abc import Mapping

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.grammar import print_block
from tracerisk.adder.blocks.lines import width_behind
from tracerisk.adder.sources.c_blocks import c_in_form, insert_c_blocks, strip_c_blocks
from tracerisk.adder.sources.edits import Edit, apply_edits, line_starts
from tracerisk.adder.sources.placed import PlacedBlock, in_other_form, targets_of
from tracerisk.adder.sources.python_lines import (
    BYTE_ORDER_MARK,
    PythonSource,
    Site,
    header_end,
    module_line,
    parse_python,
    preamble_end,
)
from tracerisk.adder.sources.read import scan_blocks
from tracerisk.adder.sources.safety import check_rewrite, check_same_program, without_blocks
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.instance_name import is_name_at
from tracerisk.config import BlockForm
from tracerisk.errors import InputError, Location, UnsafeRewriteError
from tracerisk.instrument.source.function_definitions import MODULE, definitions, normal_name
from tracerisk.instrument.source.language import is_c_like


def strip_blocks(source: bytes, file: str) -> bytes:
    """Return the source without its risk blocks; every other byte is kept.

    Raises:
        BlockError, SourceError: if a block or the source cannot be read.
        UnsafeRewriteError: if the removal would change what the program says.
    """
    if is_c_like(file):
        return strip_c_blocks(source, file)
    parsed = parse_python(source, file)
    stripped = without_blocks(parsed, scan_blocks(parsed))
    if stripped != source:
        check_same_program(parsed, parse_python(stripped, file), "removing")
    return stripped


def insert_blocks(
    source: bytes,
    blocks: Mapping[QualifiedName, RiskBlock | None],
    file: str,
    lines: Mapping[QualifiedName, int] | None = None,
) -> bytes:
    """Return the source with each of `blocks` first in the body of its function.

    A block that stands there already is replaced, `None` removes it, and the blocks of other
    functions stay as they are. A name that is defined more than once takes its block at the
    definition that `lines` gives (the line of the `def` in `source`), else where a block
    stands, else at the last one: the one that counts when all are executed.

    Raises:
        BlockError, SourceError: if a block in the source or the source cannot be read.
        InputError: if the source defines no such function.
        UnsafeRewriteError: if the result cannot be proved to change nothing else.
    """
    if is_c_like(file):
        return insert_c_blocks(source, blocks, file, lines or {})
    parsed = parse_python(source, file)
    placed = scan_blocks(parsed)
    pairs = [(MODULE, module_line(parsed))]
    pairs += [(definition.name, definition.line) for definition in definitions(parsed.tree)]
    targets = targets_of(pairs, placed, blocks, lines or {}, file)
    return insert_at(source, parsed, placed, targets)


def in_form(source: bytes, file: str, form: BlockForm) -> bytes:
    """Return the source with all its blocks in one form; they say the same as before.

    Raises as `strip_blocks`.
    """
    if is_c_like(file):
        return c_in_form(source, file, form)
    parsed = parse_python(source, file)
    placed = scan_blocks(parsed)
    return insert_at(source, parsed, placed, in_other_form(placed, form))


def insert_at(
    source: bytes,
    parsed: PythonSource,
    placed: tuple[PlacedBlock, ...],
    targets: Mapping[tuple[QualifiedName, int], RiskBlock | None],
) -> bytes:
    """Return the source with a block at each target, given by name and line of its `def`.

    `placed` are the blocks that it has. Raises as `insert_blocks`.
    """
    for (name, line), wanted in targets.items():
        if wanted is not None and normal_name(wanted.name) != name:
            raise InputError(
                f"the risk block of `{wanted.name}` is meant for `{name}`; give it that name",
                Location(parsed.file, line),
            )
    starts = line_starts(parsed)
    present = {(block.function, block.line): block for block in placed}
    needed = [key for key, wanted in targets.items() if wanted is not None and key not in present]
    sites = _sites(source, parsed, needed) if needed else {}
    edits: list[Edit] = []
    for key in sorted(targets, key=lambda key: _order(key, targets[key])):
        wanted, current = targets[key], present.get(key)
        if current is not None:
            text = b""
            if wanted is not None:
                text = _lines_of(wanted, parsed, current.first_line, current.first_line)
            start, end = starts[current.first_line - 1], starts[current.last_line]
            edits.append(Edit(start, end, text))
        elif wanted is not None:
            site = sites[key]
            at = starts[site.line - 1]
            edits.append(Edit(at, at, _lines_of(wanted, parsed, site.line - 1, site.indent_line)))
    result = apply_edits(source, edits)
    if result != source:
        kept = [b.block for b in placed if (b.function, b.line) not in targets]
        wanted_blocks = [block for block in targets.values() if block is not None]
        check_rewrite(parsed, placed, result, [*kept, *wanted_blocks])
    return result


def _order(
    key: tuple[QualifiedName, int], block: RiskBlock | None
) -> tuple[int, int, QualifiedName]:
    """Return the sort key of a block: its line, and by rank where a function has several."""
    name, line = key
    return (line, 0 if block is None else block.call_sequence.value, name)


def _lines_of(block: RiskBlock, source: PythonSource, ends_as: int, indent_line: int) -> bytes:
    """Return the block's lines as bytes.

    They have the indentation of `indent_line` and the line ending of the line `ends_as`.
    """
    line = source.lines[indent_line - 1] if source.lines else b""
    if indent_line == 1:
        line = line.removeprefix(BYTE_ORDER_MARK)
    indent = line[: len(line) - len(line.lstrip(b" \t\f"))]
    newline = _newline(source, ends_as)
    try:
        return b"".join(
            indent + text.encode(source.encoding) + newline
            for text in print_block(block, width_behind(indent))
        )
    except UnicodeEncodeError as error:
        raise UnsafeRewriteError(
            f"the risk block of {block.name} holds {error.object[error.start : error.end]!r}, "
            f"which the file's encoding {source.encoding} cannot write; declare UTF-8",
            Location(source.file, indent_line),
        ) from error


def _newline(source: PythonSource, number: int) -> bytes:
    """Return the line end of line `number`, or of the nearest line that has one."""
    for line in (*source.lines[max(number - 1, 0) :], *reversed(source.lines[: max(number, 1)])):
        for end in (b"\r\n", b"\n", b"\r"):
            if line.endswith(end):
                return end
    return b"\n"


def _sites(
    source: bytes, parsed: PythonSource, needed: list[tuple[QualifiedName, int]]
) -> dict[tuple[QualifiedName, int], Site]:
    sites: dict[tuple[QualifiedName, int], Site] = {}
    if any(name != MODULE for name, _ in needed):
        from tracerisk.adder.sources.positions import function_sites

        row = function_sites(source if parsed.converted is None else parsed.converted.encode())
        # libcst drops the line ends behind the star of `type A[*T = *B] = C`, and miscounts.
        own = {(definition.name, definition.line) for definition in definitions(parsed.tree)}
        sites.update(row if row is not None and row.keys() == own else _own_sites(parsed))
    sites[MODULE, module_line(parsed)] = _module_site(parsed)
    for (function, line), site in list(sites.items()):
        of_instances = [name for name, at in needed if at == line and is_name_at(name, function)]
        sites.update({(name, line): site for name in of_instances})
    for name, line in needed:
        if (name, line) not in sites:
            raise UnsafeRewriteError(
                f"libcst and Python's own parser report different places for {name}",
                Location(parsed.file, line),
            )
    return sites


def _own_sites(source: PythonSource) -> dict[tuple[QualifiedName, int], Site]:
    """Return the sites as Python's own parser reports them, where libcst cannot read a source."""
    sites = {}
    for definition in definitions(source.tree):
        end = header_end(source, definition)
        sites[definition.name, definition.line] = (
            Site(definition.line, definition.line)
            if end is None
            else Site(end + 1, definition.body_line)
        )
    return sites


def _module_site(source: PythonSource) -> Site:
    """Return the top of the module, after `#!` and encoding and before the docstring.

    After the docstring, formatters would put a blank line between docstring and block.
    """
    return Site(preamble_end(source) + 1, module_line(source))
