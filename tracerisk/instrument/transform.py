"""Compile a source with its tracing decorators as if it were the original.

The text that libcst wrote is parsed again and walked beside the original's syntax tree: but for
what was inserted both must be the same tree, and every node takes the original's position, so
line numbers, columns and `co_firstlineno` of the compiled code are those of the file on disk.
Then loops, `except` clauses and calls that may command are marked in the tree
itself, on the lines that they have.
"""

from __future__ import annotations

import ast
import warnings
from types import CodeType

from tracerisk.instrument.code_positions import compile_with_positions
from tracerisk.instrument.marks.busy_waits import TURNED, WAITED, mark_turns
from tracerisk.instrument.marks.calls import mark_calls
from tracerisk.instrument.marks.caught_exceptions import CAUGHT, mark_handlers
from tracerisk.instrument.marks.endless_loops import MARKER, mark_endless_loops
from tracerisk.instrument.marks.instrumented import (
    DECORATOR,
    TRACER_MODULE,
    InstrumentedSource,
    cannot_instrument,
)
from tracerisk.instrument.python_2.meaning import give_meaning
from tracerisk.instrument.source.python_2 import UNPACKED
from tracerisk.instrument.source.python_source import parse_source


def compile_instrumented(instrumented: InstrumentedSource, filename: str) -> CodeType:
    """Compile instrumented source with the original's file name and positions.

    Raises:
        UnsafeRewriteError: without the decorators the syntax tree is not the original's.
    """
    parsed = parse_source(instrumented.original, instrumented.file)
    # Unlike every other parse this one may warn (invalid escapes), once, as Python itself would.
    original = ast.parse(parsed.text, filename)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tree = ast.parse(instrumented.text, filename)
    _take_positions(tree, original, instrumented.file)
    mark_turns(tree, TRACER_MODULE)
    mark_endless_loops(tree, TRACER_MODULE, instrumented.file)
    mark_handlers(tree, TRACER_MODULE)
    inserted = frozenset({DECORATOR, MARKER, TURNED, WAITED, CAUGHT, UNPACKED})
    mark_calls(tree, TRACER_MODULE, instrumented.file, inserted)
    if parsed.is_python_2:
        give_meaning(tree)
    return compile_with_positions(tree, filename)


def _take_positions(tree: ast.Module, original: ast.Module, file: str) -> None:
    """Give every node of `tree` the position of its twin in `original`.

    Inserted nodes take that of the function they decorate, or the first line.
    """
    pending: list[tuple[ast.AST, ast.AST]] = [(tree, original)]
    while pending:
        node, twin = pending.pop()
        if type(node) is not type(twin):
            raise cannot_instrument(file, getattr(twin, "lineno", None))
        for attribute in twin._attributes:
            setattr(node, attribute, getattr(twin, attribute))
        for name in twin._fields:
            ours, theirs = getattr(node, name, None), getattr(twin, name, None)
            if isinstance(ours, list) and isinstance(theirs, list):
                own = [item for item in ours if not _is_inserted(item)]
                if len(own) != len(theirs):
                    raise cannot_instrument(file, getattr(twin, "lineno", None))
                for item in ours:
                    if _is_inserted(item):
                        _place_inserted(item, twin)
                pairs = list(zip(own, theirs, strict=True))
            else:
                pairs = [(ours, theirs)]
            for left, right in pairs:
                if isinstance(right, ast.AST) and isinstance(left, ast.AST):
                    pending.append((left, right))
                elif type(left) is not type(right) or left != right:
                    raise cannot_instrument(file, getattr(twin, "lineno", None))


def _is_inserted(node: object) -> bool:
    if isinstance(node, ast.ImportFrom):
        return node.module == TRACER_MODULE and node.level == 0
    return (
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == DECORATOR
    )


def _place_inserted(node: ast.AST, owner: ast.AST) -> None:
    line = getattr(owner, "lineno", 1)
    column = getattr(owner, "col_offset", 0)
    for item in ast.walk(node):
        if "lineno" in item._attributes:
            item.lineno = item.end_lineno = line  # type: ignore[attr-defined]
            item.col_offset = item.end_col_offset = column  # type: ignore[attr-defined]
