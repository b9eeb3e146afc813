"""Insert one tracing decorator per function, and compile the result as if it were the original.

The decorators and their import go into the syntax tree itself, on the lines that the functions
have, so line numbers, columns and `co_firstlineno` of the compiled code are those of the file on
disk, and all that Python reads can be traced.
Loops without an end, `except` clauses and calls that may command are marked likewise.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from types import CodeType

from tracerisk.instrument.code_positions import compile_with_positions
from tracerisk.instrument.marks.calls import is_compiled, mark_calls
from tracerisk.instrument.marks.caught_exceptions import CAUGHT, mark_handlers
from tracerisk.instrument.marks.endless_loops import MARKER, import_into, mark_endless_loops
from tracerisk.instrument.source.python_source import FunctionSite, parse_source

TRACER_MODULE = "__tracerisk__"
"""The module from which instrumented code imports its decorator; the loader serves it."""
DECORATOR = "__tracerisk_traced__"
"""The name of the decorator in instrumented code; not mangled in classes, hidden from `*`."""


@dataclass(frozen=True, slots=True, eq=False)
class InstrumentedSource:
    """A source with its decorators."""

    file: str
    """The path relative to the controller's root, as in every `FunctionRef`."""
    text: str
    """The source as it is on disk, decoded."""
    functions: tuple[FunctionSite, ...]
    """Every traced function in the order of the file."""

    def tree(self, filename: str = "<unknown>") -> ast.Module:
        """Return the syntax tree with a decorator at each traced function, and their import."""
        # Unlike every other parse this one may warn (invalid escapes), once, as Python does.
        tree = ast.parse(self.text, filename)
        sites = {site.line: site for site in self.functions}
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.lineno in sites:
                node.decorator_list.append(_decorator(sites[node.lineno], node))
        import_into(tree, TRACER_MODULE, {"traced": DECORATOR} if sites else {})
        return tree


def instrument_source(source: bytes, file: str) -> InstrumentedSource:
    """Find the functions that get a tracing decorator, closest to their `def`.

    Raises SourceError where the source is not Python 3, with line, column and reason.
    """
    parsed = parse_source(source, file)
    compiled = {node.lineno for node in ast.walk(parsed.tree) if is_compiled(node)}
    traced = tuple(site for site in parsed.functions if site.line not in compiled)
    return InstrumentedSource(file, parsed.text, traced)


def compile_instrumented(instrumented: InstrumentedSource, filename: str) -> CodeType:
    """Compile instrumented source with the original's file name and positions."""
    tree = instrumented.tree(filename)
    mark_endless_loops(tree, TRACER_MODULE, instrumented.file)
    mark_handlers(tree, TRACER_MODULE)
    inserted = frozenset({DECORATOR, MARKER, CAUGHT})
    mark_calls(tree, TRACER_MODULE, instrumented.file, inserted)
    return compile_with_positions(tree, filename)


def _decorator(site: FunctionSite, function: ast.FunctionDef | ast.AsyncFunctionDef) -> ast.Call:
    values = (site.ref.file, str(site.ref.name), site.line)
    call = ast.Call(ast.Name(DECORATOR, ast.Load()), [ast.Constant(value) for value in values], [])
    for node in ast.walk(call):
        if isinstance(node, ast.expr):
            node.lineno = node.end_lineno = function.lineno
            node.col_offset = node.end_col_offset = function.col_offset
    return call
