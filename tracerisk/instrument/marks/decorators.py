"""Insert one tracing decorator per function with libcst, and the import that they need."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from functools import lru_cache

import libcst as cst

from tracerisk.instrument.marks.calls import COMPILING_DECORATORS
from tracerisk.instrument.marks.endless_loops import begin_of_code
from tracerisk.instrument.marks.instrumented import (
    DECORATOR,
    TRACER_MODULE,
    InstrumentedSource,
    cannot_instrument,
)
from tracerisk.instrument.source.python_source import FunctionSite, ParsedSource, parse_source

_WITHOUT_FUNCTIONS = (cst.BaseExpression, cst.SimpleStatementLine, cst.SimpleStatementSuite)


@lru_cache(maxsize=128)
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
        if inserter.has_decorated:
            body = list(module.body)
            body.insert(_import_index(parsed.tree, body), _import_line())
            module = module.with_changes(body=body)
        return InstrumentedSource(file, source, module.code)
    except (cst.ParserSyntaxError, RecursionError) as error:
        raise cannot_instrument(file, getattr(error, "raw_line", None)) from error


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
        self.has_decorated = False

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
        self.has_decorated = True
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
