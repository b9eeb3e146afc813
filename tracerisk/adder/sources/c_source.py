"""Where the functions of a C or C++ source stand, by tree-sitter, and what is code in it.

tree-sitter reads sources as they are, before the preprocessor. It is imported only here, and only
when a C or C++ source is read.
"""

from __future__ import annotations

import bisect
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from tracerisk.common.dependencies import require_cpp
from tracerisk.common.function_ref import QualifiedName
from tracerisk.errors import Location, SourceError
from tracerisk.instrument.source.c_tokens import tokens
from tracerisk.instrument.source.language import C_SUFFIXES, CPP_SUFFIXES, is_c

if TYPE_CHECKING:
    from tree_sitter import Node, Parser, Tree

SCOPE = "::"
_NAMES = frozenset(
    {
        *("identifier", "field_identifier", "destructor_name", "operator_name", "type_identifier"),
        *("qualified_identifier", "template_function", "operator_cast"),
    }
)
_SCOPES = frozenset(
    {"namespace_definition", "class_specifier", "struct_specifier", "union_specifier"}
)
_AROUND = frozenset({"template_declaration"})
_REACH = 256
"""How many bytes back to look for a line continuation; only spaces may follow its backslash."""
_CONTINUED = re.compile(rb"(?:\\|\?\?/)[ \t]*\r?\n\Z")


@dataclass(frozen=True, slots=True)
class CFunction:
    """A function with a body; places are offsets into the source [bytes]."""

    name: QualifiedName
    """The qualified name, its scopes between `::`."""
    line: int
    """The line on which the function begins, a template's included."""
    begins: int
    """The first byte of the function, a template's included."""
    start: int
    """The first byte of the body, the brace."""
    end: int
    """The byte after the body's closing brace."""
    site: int | None
    """The byte before which a block goes; `None` where no line is free for one."""
    indent_at: int
    """The first byte of the line whose indentation the block takes."""


@dataclass(frozen=True, slots=True, eq=False)
class CSource:
    """A parsed C or C++ source."""

    file: str
    """The path in messages."""
    source: bytes
    """The content of the file."""
    tree: Tree
    """The syntax tree of tree-sitter."""
    functions: tuple[CFunction, ...]
    """The functions with a body, in the order of the file."""
    starts: tuple[int, ...]
    """The first byte of each line, (n_lines,)."""

    def line_of(self, offset: int) -> int:
        """Return the line of a byte, from 1 on."""
        return bisect.bisect_right(self.starts, offset)

    def innermost(self, offset: int) -> CFunction | None:
        """Return the innermost function whose body holds a byte."""
        around = [function for function in self.functions if function.start < offset < function.end]
        return max(around, key=lambda c_function: c_function.start, default=None)

    @property
    def first_unread(self) -> int | None:
        """The line of the first thing that tree-sitter could not read; `None` for no such."""
        node = self.tree.root_node
        while node.has_error and node.type != "ERROR" and not node.is_missing:
            node = next((child for child in node.children if child.has_error), node.children[0])
        is_bad = node.type == "ERROR" or node.is_missing
        return node.start_point.row + 1 if is_bad else None

    def leaves(self) -> Iterator[tuple[str, bytes]]:
        """Yield what the source says, in order: the kind and text of each leaf but comments."""
        cursor = self.tree.walk()
        while True:
            node = cursor.node
            if node is not None and node.type != "comment":
                if cursor.goto_first_child():
                    continue
                yield node.type, self.source[node.start_byte : node.end_byte]
            while not cursor.goto_next_sibling():
                if not cursor.goto_parent():
                    return


def parse_c(source: bytes, file: str) -> CSource:
    """Return a parsed C or C++ source.

    Raises:
        DependencyError: if the extra `cpp` is not installed.
        SourceError: if the file's suffix is that of another language, or it is not text.
    """
    if not is_c(file):
        allowed = ", ".join(sorted(C_SUFFIXES | CPP_SUFFIXES))
        raise SourceError(
            "is not a C or C++ file by its suffix, and besides Python, risk blocks are written in "
            f"no other language; allowed: {allowed}",
            Location(file),
        )
    if b"\0" in source:
        raise SourceError("holds a zero byte; is it a text file?", Location(file))
    require_cpp()
    tree = _parser("c" if file.lower().endswith(".c") else "cpp").parse(source)
    starts = (0, *(match_.end() for match_ in re.finditer(rb"\n", source)))
    return CSource(file, source, tree, tuple(_functions(source, tree, starts)), starts)


@cache
def _parser(language: str) -> Parser:
    from tree_sitter import Language, Parser

    if language == "c":
        import tree_sitter_c

        return Parser(Language(tree_sitter_c.language()))
    import tree_sitter_cpp

    return Parser(Language(tree_sitter_cpp.language()))


def _functions(source: bytes, tree: Tree, starts: Sequence[int]) -> Iterator[CFunction]:
    known = list(tokens(source))
    begins = [token.start for token in known]

    def is_code(offset: int) -> bool:
        """Whether a line from there is outside every token and continues no line before."""
        at = bisect.bisect_left(begins, offset) - 1
        is_free = at < 0 or known[at].end <= offset
        return is_free and not _CONTINUED.search(source, max(0, offset - _REACH), offset)

    stack: list[tuple[Node, str, Node | None, bool]] = [(tree.root_node, "", None, False)]
    while stack:
        node, scope, around, is_broken = stack.pop()
        inner = scope
        is_broken = is_broken or node.type == "ERROR"
        if node.type in _SCOPES:
            name = node.child_by_field_name("name")
            inner = scope if name is None else f"{scope}{_plain(name)}{SCOPE}"
        elif node.type == "function_definition" and not is_broken:
            result = _function(source, node, around or node, scope, is_code, starts)
            if result is not None:
                yield result
                inner = f"{result.name}{SCOPE}"
        outer = (around or node) if node.type in _AROUND else None
        stack += [(child, inner, outer, is_broken) for child in reversed(node.named_children)]


def _function(
    source: bytes,
    node: Node,
    around: Node,
    scope: str,
    is_code: Callable[[int], bool],
    starts: Sequence[int],
) -> CFunction | None:
    name, body = _name(node), _body(node)
    if name is None or body is None:
        return None
    begins, start, end = around.start_byte, body.start_byte, body.end_byte
    line = bisect.bisect_right(starts, begins)
    site = _line_after(source, start, end, is_code)
    if site is not None:
        indent_at = _first_code(source, site, end)
    else:
        indent_at = starts[line - 1]
        is_alone = not source[indent_at:begins].strip(b" \t")
        site = indent_at if is_alone and is_code(indent_at) else None
    return CFunction(QualifiedName(scope + name), line, begins, start, end, site, indent_at)


def _line_after(source: bytes, start: int, end: int, is_code: Callable[[int], bool]) -> int | None:
    """Return the first byte of the first line of a body where code begins."""
    at = start
    while (at := source.find(b"\n", at, end)) >= 0:
        at += 1
        if is_code(at):
            return at
    return None


def _first_code(source: bytes, site: int, end: int) -> int:
    """Return the start of the first non-blank line from a byte on."""
    at = site
    while at < end:
        stop = source.find(b"\n", at)
        stop = end if stop < 0 else stop
        if source[at:stop].strip():
            return at
        at = stop + 1
    return site


def _body(node: Node) -> Node | None:
    body = node.child_by_field_name("body")
    if body is not None and body.type == "try_statement":
        body = body.child_by_field_name("body")
    return body if body is not None and body.type == "compound_statement" else None


def _name(node: Node) -> str | None:
    """Return the name of a function as its declarator gives it, template arguments left out."""
    at = node.child_by_field_name("declarator")
    while at is not None:
        if at.type in _NAMES:
            return _plain(at) or None
        inner = at.child_by_field_name("declarator")
        at = inner if inner is not None else next(iter(at.named_children), None)
    return None


def _plain(node: Node) -> str:
    """Return the text of a name without spaces and template arguments; empty if unreadable."""
    fields = {name: node.child_by_field_name(name) for name in ("scope", "name", "type")}
    if node.type == "qualified_identifier":
        parts = [_plain(part) for part in (fields["scope"], fields["name"]) if part is not None]
        return SCOPE.join(part for part in parts if part) if parts[-1] else ""
    if node.type == "operator_cast":
        return "" if fields["type"] is None else f"operator_{_plain(fields['type'])}"
    try:
        text = (node.text or b"").decode("utf-8")
    except UnicodeDecodeError:
        return ""
    is_operator = node.type == "operator_name"
    depth, kept = 0, []
    for sign in text:
        if not is_operator and sign == "<":
            depth += 1
        elif not is_operator and sign == ">":
            depth -= 1
        elif depth == 0 and not sign.isspace():
            kept.append(sign)
    return "".join(kept).removeprefix(SCOPE)
