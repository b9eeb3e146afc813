"""Cut SysML v2 text into tokens, and take what cannot describe hardware as one token each."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from lark import Token
from lark.lexer import Lexer

from tracerisk.common.hardware.sysml.language.syntax import SourceText
from tracerisk.common.hardware.sysml.language.words import SIGNS, WORDS
from tracerisk.errors import HardwareError

MAX_DEPTH = 100
"""How deep brackets may be nested, of each kind."""

_PATTERN = re.compile(
    r"""
      (?P<SPACE>(?:[ \t\r\n\f\v]+|//\*[\s\S]*?\*/|//(?!\*)[^\n]*)+)
    | (?P<NAME>[^\W\d]\w*|°\w*)
    | (?P<SIGNS>::>|:>>|:>|:=|::|:|===|==|=>|=|!==|!=|->|\.\.|\.\?|\*\*|@@|\?\?|<=|>=
              |[;{}()\[\],@\#*%^+\-~<>|&?]|/(?![*/])|\.(?![0-9]))
    | (?P<NUMBER>(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)
    | (?P<STRING>"(?:[^"\\]|\\[\s\S])*")
    | (?P<QUOTED>'(?:[^'\\\n]|\\[^\n])*')
    | (?P<COMMENT>/\*[\s\S]*?\*/)
    | (?P<OTHER>(?!/\*|//\*|['"])[\s\S])
    """,
    re.VERBOSE,
)

_BEFORE_BODY = frozenset(
    {"_EQUALS", "_ASSIGN", "OPERATOR", "SIGN", "STAR", "STARS", "OPEN_ROUND", "_COMMA", "_DOT"}
    | {"_SELECT", "_ARROW", "_IF", "_ELSE", "NOT", "_QUESTION", "_DEFAULT", "OPEN_SQUARE"}
)
_OPENING = {"_OPEN": "_CLOSE", "OPEN_ROUND": "_CLOSE_ROUND", "OPEN_SQUARE": "_CLOSE_SQUARE"}


class Piece(Token):
    """A token that knows no lines and columns: these are worked out where they are reported.

    Made by `str.__new__`, for the constructor of lark's tokens takes a fifth of the time for
    1,000 parts.
    """

    __slots__ = ()
    line = column = end_line = end_column = end_pos = None


class SysmlLexer(Lexer):
    """The tokens of a file; a lexer of lark's own, for speed and for the elements skipped."""

    def __init__(self, lexer_conf: Any) -> None:
        del lexer_conf

    __future_interface__ = 1

    def lex(self, lexer_state: Any, parser_state: Any) -> Iterator[Token]:
        """Return the tokens of a source text."""
        del parser_state
        return iter(cut(lexer_state.text))


def cut(source: SourceText) -> list[Token]:
    """Return the tokens of a source text.

    Raises HardwareError at what begins no token, at brackets that do not match, and at what is
    nested too deep.
    """
    tokens: list[Token] = []
    append = tokens.append
    words = WORDS
    signs = SIGNS
    new = str.__new__
    stream = _matches(source)
    is_start = True  # whether a member may begin here
    open_braces: list[int] = []
    depth = 0
    for match in stream:
        kind = match.lastgroup
        at = match.start()
        value = match.group()
        if kind == "NAME":
            is_within = bool(tokens) and tokens[-1].type in ("_DOT", "_SCOPE")
            kind = "NAME" if is_within else words.get(value, "NAME")
            if is_start and (kind == "SKIPPED" or kind == "NOT"):
                append(_skip(source, match, stream))
                continue
            if kind != "PREFIX" and is_start and not (tokens and tokens[-1].type == "_HASH"):
                is_start = kind == "NAME" and _is_prefix_name(tokens)
        elif kind == "SIGNS":
            kind = signs[value]
            if kind == "_OPEN":
                if tokens and _begins_expression(tokens):
                    end = _matching(source, match, stream)
                    append(Token("BODY", source.text[at:end], at))
                    continue
                open_braces.append(at)
                if len(open_braces) > MAX_DEPTH:
                    raise _too_deep(source, at)
                is_start = True
            elif kind == "_CLOSE":
                if not open_braces:
                    raise HardwareError("unmatched '}'; remove it", source.location(at))
                open_braces.pop()
                depth = 0
                is_start = True
            elif kind == "_SEMICOLON":
                depth = 0
                is_start = True
            else:
                is_start = is_start and kind in ("_HASH", "_SCOPE")
                if kind in ("OPEN_ROUND", "OPEN_SQUARE"):
                    depth += 1
                    if depth > MAX_DEPTH:
                        raise _too_deep(source, at)
                elif kind in ("_CLOSE_ROUND", "_CLOSE_SQUARE"):
                    depth -= 1
        elif kind == "QUOTED":
            kind = "NAME"
            is_start = is_start and _is_prefix_name(tokens)
        elif kind == "COMMENT":
            is_start = True
        elif kind == "OTHER":
            raise HardwareError(_bad_character(source.text, at), source.location(at))
        else:
            is_start = False
        assert kind is not None
        token = new(Piece, value)
        token.type = kind
        token.start_pos = at
        append(token)
    if open_braces:
        raise HardwareError(
            "unclosed '{'; expected '}' before the end of the file",
            source.location(open_braces[-1]),
        )
    return tokens


def _matches(source: SourceText) -> Iterator[re.Match[str]]:
    """Yield each token's match; raise HardwareError at what begins none."""
    scan = _PATTERN.scanner(source.text).match  # type: ignore[attr-defined]
    end = 0
    while (match := scan()) is not None:
        end = match.end()
        if match.lastgroup != "SPACE":
            yield match
    if end < len(source.text):
        raise HardwareError(_bad_character(source.text, end), source.location(end))


def _bad_character(text: str, at: int) -> str:
    if text.startswith(("/*", "//*"), at):
        return "unclosed comment; expected '*/'"
    if text[at] == '"':
        return "this text is never closed; expected '\"' at its end"
    if text[at] == "'":
        return 'this quoted name is not closed; expected "\'" on the same line'
    return f"'{text[at]}' ({ascii(text[at])[1:-1]}) is not allowed here; remove it"


def _too_deep(source: SourceText, at: int) -> HardwareError:
    return HardwareError(
        f"is nested more than {MAX_DEPTH} levels deep; move the inner part into its own definition",
        source.location(at),
    )


def _is_prefix_name(found: list[Token]) -> bool:
    """Whether the name that follows belongs to metadata before an element, `#A::b part`."""
    return _follows("_HASH", found, len(found) - 1)


def _follows(sign: str, found: list[Token], index: int) -> bool:
    """Whether a sign stands before the first part of a name, whose part before ends at `index`."""
    while index > 0 and found[index].type == "_SCOPE" and found[index - 1].type == "NAME":
        index -= 2
    return index >= 0 and found[index].type == sign


def _begins_expression(found: list[Token]) -> bool:
    """Whether a brace after these tokens holds an expression, and not members."""
    last = found[-1].type
    if last in ("STAR", "STARS"):
        return found[-2].type != "_SCOPE"
    # Of a name, whether it is that of a function that is called with `->`.
    is_function = last == "NAME" and _follows("_ARROW", found, len(found) - 2)
    return last in _BEFORE_BODY or is_function


def _matching(source: SourceText, opening: re.Match[str], stream: Iterator[re.Match[str]]) -> int:
    """Read up to the bracket that closes `opening`; return the offset after it."""
    depth = 1
    for match in stream:
        sign = match.group()
        depth += (sign == "{") - (sign == "}")
        if depth == 0:
            return match.end()
    raise HardwareError(
        "unclosed '{'; expected '}' before the end of the file",
        source.location(opening.start()),
    )


def _skip(source: SourceText, word: re.Match[str], stream: Iterator[re.Match[str]]) -> Token:
    """Read an element outside the subset to its end; return it as one token."""
    for match in stream:
        if match.lastgroup != "SIGNS":
            continue
        sign = match.group()
        if sign == "{":
            end = _matching(source, match, stream)
            break
        if sign == "}":
            raise HardwareError(
                f"expected ';' at the end of this '{word.group()}', found '}}'",
                source.location(match.start()),
            )
        if sign == ";":
            end = match.end()
            break
    else:
        raise HardwareError(
            f"this '{word.group()}' has no end; expected ';' or '{{ ... }}'",
            source.location(word.start()),
        )
    return Token("SKIPPED", source.text[word.start() : end], word.start())
