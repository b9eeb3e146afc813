"""Parse the text of a SysML v2 file into its syntax tree."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from lark import Lark
from lark.exceptions import UnexpectedToken, VisitError

from tracerisk.common.hardware.sysml.language.expected import syntax_error
from tracerisk.common.hardware.sysml.language.syntax import Package, SourceText
from tracerisk.common.hardware.sysml.language.tokens import SysmlLexer
from tracerisk.common.hardware.sysml.language.tree import NotationError, TreeBuilder, meaningless


@cache
def _parser() -> Lark:
    """Build the parser's tables, once a process."""
    grammar = Path(__file__).with_name("grammar.lark")
    return Lark(
        grammar.read_text(encoding="utf-8"),
        parser="lalr",
        lexer=SysmlLexer,
        transformer=TreeBuilder(),
    )


def parse(source: SourceText) -> Package:
    """Return the syntax tree of a file.

    Raises HardwareError with file, line, column and what was expected.
    """
    try:
        return _parser().parse(source)  # type: ignore[return-value]
    except UnexpectedToken as found:
        raise syntax_error(found, source) from None
    except NotationError as problem:
        raise meaningless(problem, source) from None
    except VisitError as error:
        if isinstance(error.orig_exc, NotationError):
            raise meaningless(error.orig_exc, source) from None
        raise
