"""A source as libcst reads it, with the place of each node in its bytes."""

from __future__ import annotations

import io
import tokenize
from bisect import bisect_right
from itertools import accumulate
from typing import cast

import libcst as cst
from libcst.metadata import ByteSpanPositionProvider, CodeSpan, MetadataWrapper

from tracerisk.adder.sources.python_lines import BYTE_ORDER_MARK
from tracerisk.errors import Location, UnsafeRewriteError
from tracerisk.instrument.source.function_definitions import MODULE
from tracerisk.instrument.source.python_source import parse_source
from tracerisk.pipeline.mutation.change import Change, ChangeKind, Draft, brief

_MAIN_TEST = "__name__"


class SourceTree:
    """A file of a controller, parsed; ranges of nodes leave out parentheses around them."""

    def __init__(self, source: bytes, file: str) -> None:
        """Parse the source.

        Raises SourceError where it is not Python, UnsafeRewriteError where libcst cannot read it.
        """
        self.source, self.file = source, file
        read = parse_source(source, file)
        if read.is_python_2:
            raise UnsafeRewriteError(
                "is Python 2, of which no part is changed for a trial; convert it first, e.g. with "
                f"`2to3 -w {file}`",
                Location(file),
            )
        text = read.text
        try:
            wrapper = MetadataWrapper(cst.parse_module(text), unsafe_skip_copy=True)
            spans = wrapper.resolve(ByteSpanPositionProvider)
        except (cst.ParserSyntaxError, cst.CSTLogicError, RecursionError) as error:
            raise UnsafeRewriteError(
                "libcst does not read the source as Python does; nothing of it is changed",
                Location(file, getattr(error, "raw_line", None)),
            ) from error
        self.module = wrapper.module
        self._spans = cast("dict[cst.CSTNode, CodeSpan]", spans)
        self._utf8 = text.encode()
        lengths = map(len, self._utf8.splitlines(keepends=True))
        self._line_starts = [0, *accumulate(lengths)]
        self._encoding = tokenize.detect_encoding(io.BytesIO(source).readline)[0]
        self._skipped = len(BYTE_ORDER_MARK) if source.startswith(BYTE_ORDER_MARK) else 0

    def span(self, node: cst.CSTNode) -> tuple[int, int]:
        """Return where a node begins and ends."""
        result = self._spans[node]
        return result.start, result.start + result.length

    def code(self, node: cst.CSTNode) -> str:
        """Return a node as it is written, without parentheses around it."""
        return self.between(*self.span(node))

    def whole(self, node: cst.CSTNode) -> str:
        """Return a node as it is written, with parentheses around it."""
        return self.module.code_for_node(node)

    def between(self, start: int, end: int) -> str:
        """Return what is written between two places."""
        return self._utf8[start:end].decode()

    def line(self, at: int) -> int:
        """Return the line of a place, from 1."""
        return bisect_right(self._line_starts, at)

    def replaced(self, node: cst.CSTNode, new: str, kind: ChangeKind, words: str = "") -> Draft:
        """Return the draft that puts other text in the place of a node."""
        shown = words or f"{brief(self.code(node))} becomes {brief(new)}"
        return Draft(*self.span(node), new, kind, shown)

    def change(self, draft: Draft, function: str) -> Change:
        """Return the change of the file's own bytes that a draft makes."""
        start, end = self._place(draft.start), self._place(draft.end)
        return Change(
            self.file,
            start,
            end,
            self.source[start:end],
            draft.new.encode(self._plain_encoding),
            draft.kind,
            self.line(draft.start),
            function,
            draft.words,
        )

    @property
    def _plain_encoding(self) -> str:
        return "utf-8" if self._encoding == "utf-8-sig" else self._encoding

    def _place(self, at: int) -> int:
        if self._plain_encoding == "utf-8":
            return self._skipped + at
        return self._skipped + len(self.between(0, at).encode(self._plain_encoding))


# What takes no part in what a run brings about, or is no place for a change.
_LEFT_OUT = (
    *(cst.Import, cst.ImportFrom, cst.Annotation, cst.Decorator, cst.FormattedString),
    *(cst.ConcatenatedString, cst.Raise, cst.Global, cst.Nonlocal, cst.MatchPattern),
)
_SAYING = frozenset(
    {
        *("print", "debug", "info", "warn", "warning", "error", "critical", "fatal", "exception"),
        *("logdebug", "loginfo", "logwarn", "logerr", "logfatal", "get_logger", "getLogger"),
    }
)


def last_name(node: cst.BaseExpression) -> str:
    """Return the last name of what is called: `go` of `self.arm.go`; empty for none."""
    if isinstance(node, cst.Attribute):
        return node.attr.value
    return node.value if isinstance(node, cst.Name) else ""


def is_saying(call: cst.Call) -> bool:
    """Return whether a call only prints or logs."""
    name = last_name(call.func)
    return name.partition("_")[0] in _SAYING or name in _SAYING


class Walk(cst.CSTVisitor):
    """Goes through a source in order, and knows what stands above a node."""

    def __init__(self, tree: SourceTree) -> None:
        super().__init__()
        self.tree = tree
        self.above: list[cst.CSTNode] = []
        """The nodes around the present one, the outermost first."""
        self._prefixes = [""]
        self._functions = [str(MODULE)]
        self._owners = [""]

    @property
    def function(self) -> str:
        """The qualified name of the function around the present node."""
        return self._functions[-1]

    @property
    def owner(self) -> str:
        """The qualified name of the class around the present node; empty for none."""
        return self._owners[-1]

    @property
    def parent(self) -> cst.CSTNode:
        """The node right around the present one; the module is its own."""
        return self.above[-1] if self.above else self.tree.module

    def at(self, node: cst.CSTNode) -> None:
        """Look at a node; to be given by who walks."""

    def on_visit(self, node: cst.CSTNode) -> bool:
        """Look at a node, and say whether to go on below it."""
        is_left_out = (
            isinstance(node, _LEFT_OUT)
            or (isinstance(node, cst.Call) and is_saying(node))
            or (isinstance(node, cst.If) and _MAIN_TEST in self.tree.code(node.test))
        )
        if not is_left_out:
            self.at(node)
        self.above.append(node)
        if isinstance(node, cst.ClassDef):
            self._owners.append(f"{self._prefixes[-1]}{node.name.value}")
            self._prefixes.append(f"{self._owners[-1]}.")
        elif isinstance(node, cst.FunctionDef):
            name = f"{self._prefixes[-1]}{node.name.value}"
            self._functions.append(name)
            self._prefixes.append(f"{name}.<locals>.")
        return not is_left_out

    def on_leave(self, original_node: cst.CSTNode) -> None:
        """Leave a node."""
        self.above.pop()
        if isinstance(original_node, _SCOPES):
            self._prefixes.pop()
        if isinstance(original_node, cst.FunctionDef):
            self._functions.pop()
        elif isinstance(original_node, cst.ClassDef):
            self._owners.pop()


_SCOPES = (cst.ClassDef, cst.FunctionDef)


def call_of(statement: cst.CSTNode) -> cst.Call | None:
    """Return the call that is all of a statement, awaited or not; `None` for another one."""
    if not isinstance(statement, cst.SimpleStatementLine) or len(statement.body) != 1:
        return None
    node = statement.body[0]
    value = node.value if isinstance(node, cst.Expr) else None
    if isinstance(value, cst.Await):
        value = value.expression
    return value if isinstance(value, cst.Call) and not is_saying(value) else None


def number_of(node: cst.CSTNode) -> int | float | None:
    """Return the value of a number as it is written, its sign included; `None` for another node."""
    if isinstance(node, cst.Integer | cst.Float):
        return node.evaluated_value
    if isinstance(node, cst.UnaryOperation) and isinstance(node.operator, cst.Minus):
        value = number_of(node.expression)
        return None if value is None else -value
    return None
