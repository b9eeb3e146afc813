"""The proof that a rewrite of a source changed its risk blocks and nothing else.

libcst said where the lines went in; what is checked here rests on Python's own parser.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.sources.edits import Edit, apply_edits, line_starts
from tracerisk.adder.sources.placed import PlacedBlock, check_same_blocks, check_same_bytes
from tracerisk.adder.sources.python_lines import PythonSource, parse_python
from tracerisk.adder.sources.read import scan_blocks
from tracerisk.errors import BlockError, InputError, Location, UnsafeRewriteError


def without_blocks(source: PythonSource, placed: Iterable[PlacedBlock]) -> bytes:
    """Return the bytes of a source without the lines of its blocks."""
    starts = line_starts(source)
    edits = [Edit(starts[b.first_line - 1], starts[b.last_line], b"") for b in placed]
    return apply_edits(b"".join(source.lines), edits)


def check_rewrite(
    before: PythonSource,
    placed: Iterable[PlacedBlock],
    result: bytes,
    expected: Iterable[RiskBlock],
) -> None:
    """Refuse a result that is not proved to be the source with the expected blocks.

    `placed` are the blocks of the source as it was.

    Raises:
        UnsafeRewriteError: with the reason, if the result cannot be read, does not give the
            same bytes without its blocks, is another program, or holds other blocks.
    """
    try:
        after = parse_python(result, before.file)
        placed_after = scan_blocks(after)
    except BlockError as error:
        raise UnsafeRewriteError(
            "with the risk block in, its lines could not be distinguished from a comment "
            "beside it: "
            f"{error.message}",
            error.location,
        ) from error
    except InputError as error:
        raise UnsafeRewriteError(
            f"with the risk block in, the file would no longer be read: {error.message}",
            error.location,
        ) from error
    bare = without_blocks(before, placed)
    check_same_bytes(bare, without_blocks(after, placed_after), before.file)
    check_same_program(before, after, "adding")
    check_same_blocks(expected, placed_after, before.file)


def check_same_program(before: PythonSource, after: PythonSource, what: str) -> None:
    """Refuse a rewrite (`what`: "adding", "removing") that made another program of a source.

    Raises:
        UnsafeRewriteError: with the line where the syntax trees part.
    """
    difference = _first_difference(before.tree, after.tree)
    if difference is not None:
        raise UnsafeRewriteError(
            f"{what} risk blocks would change what the program says",
            Location(before.file, difference),
        )


def _first_difference(one: ast.AST, other: ast.AST) -> int | None:
    """Return the line where two trees differ, places aside; `None` where they are the same.

    Without recursion, for a sum of a thousand terms is a tree a thousand deep.
    """
    stack: list[tuple[object, object, int]] = [(one, other, 1)]
    while stack:
        left, right, line = stack.pop()
        if type(left) is not type(right):
            return line
        if isinstance(left, ast.AST):
            line = getattr(left, "lineno", line)
            stack += [
                (getattr(left, name, None), getattr(right, name, None), line)
                for name in left._fields
            ]
        elif isinstance(left, list) and isinstance(right, list):
            if len(left) != len(right):
                return line
            stack += [(a, b, line) for a, b in zip(left, right, strict=True)]
        elif isinstance(left, float | complex):
            if repr(left) != repr(right):
                return line
        elif left != right:
            return line
    return None
