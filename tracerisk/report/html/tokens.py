"""The words of a source line by kind, so that the page can colour them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

_MOST_CHARACTERS = 400_000
"""A longer source is shown without colours."""


@dataclass(frozen=True, slots=True)
class Token:
    """A part of a source line."""

    text: str
    """The characters."""
    kind: str = ""
    """Class in the page's style; "" for plain text."""


def tokens_of(file: str, lines: Sequence[str]) -> Iterator[tuple[Token, ...]]:
    """Yield the tokens of each line; the texts of a line's tokens are the line."""
    if sum(map(len, lines)) > _MOST_CHARACTERS:
        yield from ((Token(line),) for line in lines)
        return
    from pygments.lexers import CppLexer, JavaLexer, PythonLexer

    kinds: dict[str, Any] = {".java": JavaLexer, ".py": PythonLexer}
    suffix = file[file.rfind(".") :].lower() if "." in file else ".py"
    lexer = kinds.get(suffix, CppLexer)(stripnl=False, ensurenl=False, stripall=False)
    current: list[Token] = []
    count = 0
    for kind, text in lexer.get_tokens("\n".join(lines)):
        name = _class_of(kind)
        first, *more = text.split("\n")
        if first:
            current.append(Token(first, name))
        for part in more:
            yield tuple(current)
            count += 1
            current = [Token(part, name)] if part else []
    if count < len(lines):
        yield tuple(current)


def _class_of(kind: Any) -> str:
    from pygments.token import Comment, Keyword, Name, Number, Operator, String

    for parent, name in (
        (Comment, "comment"),
        (String, "string"),
        (Number, "literal"),
        (Keyword, "keyword"),
        (Operator.Word, "keyword"),
        (Name.Function, "defined"),
        (Name.Class, "defined"),
        (Name.Decorator, "defined"),
    ):
        if kind in parent:
            return name
    return ""
