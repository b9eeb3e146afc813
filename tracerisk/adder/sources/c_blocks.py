"""Risk blocks of C and C++ sources: found, put in and taken out, with no other byte changed.

    void pick() {
      /***
       * RiskAnnotation 4Xe9aB
       * @Function {
       *   name = pick
       ...
       * }
       ***/

A block is a comment on lines of its own, in the form of the published method, at the top of the
function's body; above the function where its body is one line. To the preprocessor it is a space,
so the compiled program stays the same. Each result is checked before it is handed out.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.grammar import print_block
from tracerisk.adder.blocks.lines import GUTTER, width_behind
from tracerisk.adder.sources.c_source import SCOPE, CFunction, CSource, parse_c
from tracerisk.adder.sources.edits import Edit, apply_edits
from tracerisk.adder.sources.placed import (
    MisplacedBlockError,
    PlacedBlock,
    check_same_blocks,
    check_same_bytes,
    in_other_form,
    targets_of,
)
from tracerisk.adder.sources.published import CComment, c_comments
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.instance_name import is_name_at
from tracerisk.config import BlockForm
from tracerisk.errors import BlockError, InputError, Location, UnsafeRewriteError

_BLANK_OR_COMMENT = re.compile(rb"(?:\s|//[^\n]*\n|/\*.*?\*/)*", re.DOTALL)


def scan_c_blocks(source: bytes, file: str) -> tuple[PlacedBlock, ...]:
    """Return the blocks of a C or C++ source in the order of the file.

    A block that says `pick` may stand in `Robot::pick`, which it then describes.

    Raises:
        BlockError: if a block is malformed, stands at no function, or at another than it names.
        DependencyError, SourceError: as `parse_c`.
    """
    comments = list(c_comments(source, file))
    if not comments:
        return ()
    return tuple(_placed(parse_c(source, file), comments))


def c_block_lines(source: bytes, file: str) -> tuple[int, ...]:
    """Return the lines that belong to risk blocks, ascending."""
    return tuple(
        line
        for comment in c_comments(source, file)
        for line in range(comment.line, comment.line + _lines_in(source, comment))
    )


def strip_c_blocks(source: bytes, file: str) -> bytes:
    """Return the source without its risk blocks; every other byte is kept.

    Raises as `scan_c_blocks`, and UnsafeRewriteError if the source would say something else.
    """
    comments = list(c_comments(source, file))
    if not comments:
        return source
    stripped = _without(source, comments, file)
    _check_same_program(parse_c(source, file), parse_c(stripped, file), "removing")
    return stripped


def insert_c_blocks(
    source: bytes,
    blocks: Mapping[QualifiedName, RiskBlock | None],
    file: str,
    lines: Mapping[QualifiedName, int],
) -> bytes:
    """Return the source with each of `blocks` in its function; see `insert_blocks`."""
    parsed = parse_c(source, file)
    placed = tuple(_placed(parsed, c_comments(source, file)))
    pairs = [(function.name, function.line) for function in parsed.functions]
    line = parsed.first_unread
    hint = "" if line is None else f"; from line {line} on something cannot be read without macros"
    return insert_c_at(parsed, placed, targets_of(pairs, placed, blocks, lines, file, hint))


def c_in_form(source: bytes, file: str, form: BlockForm) -> bytes:
    """Return the source with all its blocks in one form; see `in_form`."""
    comments = list(c_comments(source, file))
    if not comments:
        return source
    parsed = parse_c(source, file)
    placed = tuple(_placed(parsed, comments))
    return insert_c_at(parsed, placed, in_other_form(placed, form))


def insert_c_at(
    parsed: CSource,
    placed: Sequence[PlacedBlock],
    targets: Mapping[tuple[QualifiedName, int], RiskBlock | None],
) -> bytes:
    """Return the source with a block at each target; see `insert_at`."""
    source, file = parsed.source, parsed.file
    spans = {(block.function, block.line): block for block in placed}
    edits = []
    for (name, line), wanted in targets.items():
        current = spans.get((name, line))
        if current is not None:
            start = parsed.starts[current.first_line - 1]
            end = [*parsed.starts, len(source)][current.last_line]
            text = b"" if wanted is None else _text(wanted, source, start, start, file)
            edits.append(Edit(start, end, text))
        elif wanted is not None:
            function = _definition(parsed, name, line)
            if function.site is None:
                raise UnsafeRewriteError(
                    f"there is no place for the risk block of {name}: something else precedes the "
                    "function on its line; begin the function on a line of its own",
                    Location(file, line),
                )
            text = _text(wanted, source, function.site, function.indent_at, file)
            edits.append(Edit(function.site, function.site, text))
    result = apply_edits(source, edits)
    if result != source:
        kept = [b.block for b in placed if (b.function, b.line) not in targets]
        expected = [*kept, *(block for block in targets.values() if block is not None)]
        _check_rewrite(parsed, result, expected)
    return result


def _definition(parsed: CSource, name: QualifiedName, line: int) -> CFunction:
    return next(
        function
        for function in parsed.functions
        if function.line == line and is_name_at(name, function.name)
    )


def _placed(parsed: CSource, comments: Iterable[CComment]) -> Iterable[PlacedBlock]:
    for comment in comments:
        if len(comment.blocks) > 1:
            raise BlockError(
                "this comment holds several risk blocks; give each a comment of its own",
                Location(parsed.file, comment.line),
            )
        block = comment.blocks[0]
        owners = _owners(parsed, comment)
        if not owners:
            raise BlockError(
                "a risk block stands where no function is; allowed: in a function's body, or "
                "directly above a function",
                Location(parsed.file, comment.line),
            )
        named = [c_function for c_function in owners if _is_meant(block.name, c_function.name)]
        if not named:
            functions = (c_function.name for c_function in owners)
            place = Location(parsed.file, comment.line)
            raise MisplacedBlockError(block, QualifiedName(block.name), functions, place)
        last = comment.line + _lines_in(parsed.source, comment) - 1
        owner = named[0]
        name = block.name if is_name_at(block.name, owner.name) else owner.name
        yield PlacedBlock(
            block if block.name == name else replace(block, name=name),
            QualifiedName(name),
            owner.line,
            "body" if owner.start < comment.start else "above",
            comment.line,
            last,
        )


def _is_meant(name: str, function: QualifiedName) -> bool:
    return is_name_at(name, function) or function.endswith(f"{SCOPE}{name}")


def _owners(parsed: CSource, comment: CComment) -> list[CFunction]:
    """Return the functions that a comment may describe: the one around it, and the one below it."""
    around = parsed.innermost(comment.start)
    c_functions = [] if around is None else [around]
    below = _BLANK_OR_COMMENT.match(parsed.source, comment.end)
    assert below is not None
    return [
        *c_functions,
        *(function for function in parsed.functions if function.begins == below.end()),
    ]


def _lines_in(source: bytes, comment: CComment) -> int:
    return source.count(b"\n", comment.start, comment.end) + 1


def _without(source: bytes, comments: Sequence[CComment], file: str) -> bytes:
    edits = []
    for comment in comments:
        start = source.rfind(b"\n", 0, comment.start) + 1
        end = source.find(b"\n", comment.end)
        end = len(source) if end < 0 else end + 1
        if source[start : comment.start].strip() or source[comment.end : end].strip():
            raise BlockError(
                "something else stands on a line of this risk block; give the block lines of its "
                "own",
                Location(file, comment.line),
            )
        edits.append(Edit(start, end, b""))
    return apply_edits(source, edits)


def _text(block: RiskBlock, source: bytes, at: int, indent_at: int, file: str) -> bytes:
    """Return the comment as bytes.

    It has the indentation of the line at `indent_at`, and the line ending of the line before `at`.
    """
    line = source[indent_at:].partition(b"\n")[0]
    indent = line[: len(line) - len(line.lstrip(b" \t"))]
    if line.lstrip(b" \t").startswith(b"}"):
        indent += b"\t" if b"\t" in indent else b"  "
    before = source[at - 2 : at] if at else source[: source.find(b"\n") + 1]
    newline = b"\r\n" if before.endswith(b"\r\n") else b"\n"
    printed = print_block(block, width_behind(indent))
    lines = [" * " + each.removeprefix(GUTTER) for each in printed]
    for printed_line in lines:
        if "*/" in printed_line:
            raise UnsafeRewriteError(
                f"the risk block of {block.name} holds `*/`, which would end its comment; write "
                "the reason in other words",
                Location(file, source.count(b"\n", 0, at) + 1),
            )
    return b"".join(indent + text.encode() + newline for text in ("/***", *lines, " ***/"))


def _check_rewrite(before: CSource, result: bytes, expected: Sequence[RiskBlock]) -> None:
    """Refuse a result that is not proved to be the source with the expected blocks."""
    try:
        results = list(c_comments(result, before.file))
        after = parse_c(result, before.file)
        placed = tuple(_placed(after, results))
    except InputError as error:
        raise UnsafeRewriteError(
            f"with the risk block in, the file would no longer be read: {error.message}",
            error.location,
        ) from error
    comments = list(c_comments(before.source, before.file))
    bare = _without(before.source, comments, before.file)
    check_same_bytes(bare, _without(result, results, before.file), before.file)
    _check_same_program(before, after, "adding")
    check_same_blocks(expected, placed, before.file)


def _check_same_program(before: CSource, after: CSource, what: str) -> None:
    """Refuse a rewrite after which the source does not say the same, comments aside."""
    if list(before.leaves()) != list(after.leaves()):
        raise UnsafeRewriteError(
            f"{what} risk blocks would change how the source is read", Location(before.file)
        )
