"""Where libcst sees the bodies of functions; the only module here that imports it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import cast

import libcst as cst
from libcst.metadata import CodeRange, MetadataWrapper, PositionProvider

from tracerisk.adder.sources.python_lines import Site
from tracerisk.common.function_ref import QualifiedName
from tracerisk.errors import interruption
from tracerisk.instrument.source.function_definitions import normal_name


@lru_cache(maxsize=8)
def function_sites(source: bytes) -> Mapping[tuple[QualifiedName, int], Site] | None:
    """Return where the block of each function goes, by qualified name and line of the `def`.

    `None` if libcst cannot read the source: it rejects some that CPython accepts
    (`(x): int`), and a string of a thousand parts or a sum of as many is too deep for it.
    """
    try:
        wrapper = MetadataWrapper(cst.parse_module(source), unsafe_skip_copy=True)
        positions = cast(Mapping[cst.CSTNode, CodeRange], wrapper.resolve(PositionProvider))
        collector = _SiteCollector(positions)
        wrapper.module.visit(collector)
    except (cst.ParserSyntaxError, cst.CSTLogicError, RecursionError):
        return None
    except KeyError as error:
        # Inside a function, libcst's position provider turns any exception into a KeyError.
        if (ended := interruption(error)) is not None:
            raise ended from None
        return None
    return collector.sites


class _SiteCollector(cst.CSTVisitor):
    def __init__(self, positions: Mapping[cst.CSTNode, CodeRange]) -> None:
        super().__init__()
        self._positions = positions
        self._prefixes = [""]
        self.sites: dict[tuple[QualifiedName, int], Site] = {}

    def on_visit(self, node: cst.CSTNode) -> bool:
        if isinstance(node, cst.ClassDef):
            self._prefixes.append(f"{self._prefixes[-1]}{normal_name(node.name.value)}.")
        elif isinstance(node, cst.FunctionDef):
            name = f"{self._prefixes[-1]}{normal_name(node.name.value)}"
            line = self._positions[node].start.line
            self.sites[QualifiedName(name), line] = self._site(node, line)
            self._prefixes.append(f"{name}.<locals>.")
        # No function is defined inside an expression or a simple statement.
        return not isinstance(node, cst.BaseExpression | cst.SimpleStatementLine)

    def on_leave(self, original_node: cst.CSTNode) -> None:
        if isinstance(original_node, cst.ClassDef | cst.FunctionDef):
            self._prefixes.pop()

    def _site(self, node: cst.FunctionDef, line: int) -> Site:
        if not isinstance(node.body, cst.IndentedBlock):
            return Site(line, line)
        header_end = self._positions[node.body.header.newline].start.line
        return Site(header_end + 1, self._positions[node.body.body[0]].start.line)
