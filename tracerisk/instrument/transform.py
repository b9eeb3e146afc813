"""Insert one tracing decorator per function, and compile the result as if it were the original.

The text that libcst writes is parsed again and walked beside the original's syntax tree: but for
what was inserted both must be the same tree, and every node takes the original's position, so
line numbers, columns and `co_firstlineno` of the compiled code are those of the file on disk.
Then loops without an end, `except` clauses and calls that may command are marked in the tree
itself, on the lines that they have.
"""

from __future__ import annotations

import ast
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from types import CodeType

import libcst as cst

from tracerisk.errors import Location, UnsafeRewriteError
from tracerisk.instrument.code_positions import compile_with_positions
from tracerisk.instrument.marks.calls import COMPILING_DECORATORS, mark_calls
from tracerisk.instrument.marks.caught_exceptions import CAUGHT, mark_handlers
from tracerisk.instrument.marks.endless_loops import MARKER, begin_of_code, mark_endless_loops
from tracerisk.instrument.python_2.meaning import give_meaning
from tracerisk.instrument.source.python_2 import UNPACKED
from tracerisk.instrument.source.python_source import FunctionSite, ParsedSource, parse_source

TRACER_MODULE = "__tracerisk__"
"""The module from which instrumented code imports its decorator; the loader serves it."""
DECORATOR = "__tracerisk_traced__"
"""The name of the decorator in instrumented code; not mangled in classes, hidden from `*`."""

_WITHOUT_FUNCTIONS = (cst.BaseExpression, cst.SimpleStatementLine, cst.SimpleStatementSuite)


@dataclass(frozen=True, slots=True)
class InstrumentedSource:
    """A source with the tracer's decorators."""

    file: str
    """The path from the controller's root, as in every `FunctionRef`."""
    original: bytes
    """The bytes on disk."""
    text: str
    """The instrumented source, decoded."""
    functions: tuple[FunctionSite, ...]
    """Every traced function, in the order of the file."""


def instrument_source(source: bytes, file: str) -> InstrumentedSource:
    """Insert a tracing decorator closest to each `def`, and the import that it needs.

    Raises:
        SourceError: the source is not Python, with line, column and reason.
        UnsafeRewriteError: libcst cannot read what Python can.
    """
    parsed = parse_source(source, file)
    inserter = _DecoratorInserter(parsed)
    try:
        module = _read(parsed).visit(inserter)
    except (cst.ParserSyntaxError, RecursionError) as error:
        raise _cannot_instrument(file, getattr(error, "raw_line", None)) from error
    if inserter.sites:
        body = list(module.body)
        body.insert(_import_index(parsed.tree, body), _import_line())
        module = module.with_changes(body=body)
    return InstrumentedSource(file, source, module.code, tuple(inserter.sites))


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
    mark_endless_loops(tree, TRACER_MODULE, instrumented.file)
    mark_handlers(tree, TRACER_MODULE)
    inserted = frozenset({DECORATOR, MARKER, CAUGHT, UNPACKED})
    mark_calls(tree, TRACER_MODULE, instrumented.file, inserted)
    if parsed.is_python_2:
        give_meaning(tree)
    return compile_with_positions(tree, filename)


def _read(parsed: ParsedSource) -> cst.Module:
    """Return what libcst reads: where that is not all that Python does, Python's own rendering."""
    try:
        return cst.parse_module(parsed.text)
    except (cst.ParserSyntaxError, cst.CSTLogicError):
        # A tab after spaces, or `rt"a" t"b"`. Positions are those of the original in any case.
        return cst.parse_module(ast.unparse(parsed.tree))


class _DecoratorInserter(cst.CSTTransformer):
    """Adds the decorator to every function; meets them in the order of `ParsedSource.functions`."""

    def __init__(self, parsed: ParsedSource) -> None:
        super().__init__()
        self._remaining = iter(parsed.functions)
        self._open: list[FunctionSite] = []
        self._met: list[FunctionSite] = []

    @property
    def sites(self) -> list[FunctionSite]:
        """The functions that were decorated, in the order of the file."""
        return sorted(self._met, key=lambda site: site.line)

    def on_visit(self, node: cst.CSTNode) -> bool:
        # No function is defined inside an expression or a simple statement: they are most of a
        # source, and libcst makes each part that it goes through anew.
        return super().on_visit(node) and not isinstance(node, _WITHOUT_FUNCTIONS)

    def visit_FunctionDef(self, node: cst.FunctionDef) -> None:  # noqa: N802, ARG002
        self._open.append(next(self._remaining))

    def leave_FunctionDef(  # noqa: N802
        self, original_node: cst.FunctionDef, updated_node: cst.FunctionDef
    ) -> cst.FunctionDef:
        site = self._open.pop()
        if any(
            _last_name(decorator.decorator) in COMPILING_DECORATORS
            for decorator in original_node.decorators
        ):
            return updated_node
        self._met.append(site)
        return updated_node.with_changes(
            decorators=[*updated_node.decorators, cst.Decorator(_decorator_call(site))]
        )


def _last_name(decorator: cst.BaseExpression) -> str:
    if isinstance(decorator, cst.Call):
        decorator = decorator.func
    if isinstance(decorator, cst.Attribute):
        return decorator.attr.value
    return decorator.value if isinstance(decorator, cst.Name) else ""


def _decorator_call(site: FunctionSite) -> cst.Call:
    # ascii(): the source's own encoding may not have the letters of a file name.
    return cst.Call(
        cst.Name(DECORATOR),
        [
            cst.Arg(cst.SimpleString(ascii(site.ref.file))),
            cst.Arg(cst.SimpleString(ascii(str(site.ref.name)))),
            cst.Arg(cst.Integer(str(site.line))),
        ],
    )


def _import_line() -> cst.SimpleStatementLine:
    alias = cst.ImportAlias(cst.Name("traced"), asname=cst.AsName(cst.Name(DECORATOR)))
    return cst.SimpleStatementLine([cst.ImportFrom(cst.Name(TRACER_MODULE), [alias])])


def _import_index(tree: ast.Module, body: Sequence[cst.BaseStatement]) -> int:
    """Count the lines of the docstring and the `from __future__` imports, which must stay first."""
    remaining, index = begin_of_code(tree), 0
    while remaining > 0:
        line = body[index]
        assert isinstance(line, cst.SimpleStatementLine)
        remaining -= len(line.body)
        index += 1
    return index


def _take_positions(tree: ast.Module, original: ast.Module, file: str) -> None:
    """Give every node of `tree` the position of its twin in `original`.

    Inserted nodes take that of the function they decorate, or the first line.
    """
    pending: list[tuple[ast.AST, ast.AST]] = [(tree, original)]
    while pending:
        node, twin = pending.pop()
        if type(node) is not type(twin):
            raise _cannot_instrument(file, getattr(twin, "lineno", None))
        for attribute in twin._attributes:
            setattr(node, attribute, getattr(twin, attribute))
        for name in twin._fields:
            ours, theirs = getattr(node, name, None), getattr(twin, name, None)
            if isinstance(ours, list) and isinstance(theirs, list):
                own = [item for item in ours if not _is_inserted(item)]
                if len(own) != len(theirs):
                    raise _cannot_instrument(file, getattr(twin, "lineno", None))
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
                    raise _cannot_instrument(file, getattr(twin, "lineno", None))


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


def _cannot_instrument(file: str, line: int | None) -> UnsafeRewriteError:
    return UnsafeRewriteError(
        "the source cannot be instrumented with proof that nothing else changes: libcst does not "
        "read it as Python does; rewrite this statement in a plainer way, or move it to a module "
        "that commands no motion",
        Location(file, line),
    )
