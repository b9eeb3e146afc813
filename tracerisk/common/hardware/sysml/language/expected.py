"""Explain what was expected where a SysML v2 file cannot be parsed, in its author's words."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from lark import Token
from lark.exceptions import UnexpectedToken

from tracerisk.common.hardware.sysml.language.syntax import SourceText
from tracerisk.common.hardware.sysml.language.words import SIGNS, WORDS
from tracerisk.errors import HardwareError

_SIGN_OF = {
    terminal: f"'{sign}'"
    for sign, terminal in SIGNS.items()
    if terminal.startswith("_") or terminal in ("OPEN_ROUND", "OPEN_SQUARE", "DOTS", "GREATER")
}
_WORD_OF = {terminal: f"'{word}'" for word, terminal in WORDS.items() if terminal.startswith("_")}

_PLAIN = {
    **_SIGN_OF,
    **_WORD_OF,
    "NAME": "a name",
    "COMMENT": "a comment /* ... */",
    "STRING": "a text in double quotes",
    "STAR": "'*'",
    "STARS": "'**'",
    "_EQUALS": "'='",
    "$END": "the end of the file",
    "_COMMENT": "'comment'",
}
"""What the terminals are called; those that are missing go by their groups."""

_MEMBER = frozenset({"KIND", "_PACKAGE", "_METADATA", "SKIPPED"})
_VALUE = frozenset({"NUMBER", "STRING", "BOOLEAN", "NULL"})
_SILENT = frozenset(
    {"OPERATOR", "SIGN", "LESS", "GREATER", "STAR", "STARS", "AT", "DOTS", "_HASH", "_ARROW"}
    | {"_SELECT", "BODY", "TILDE", "FLAG", "_LOCALE", "_DEFINED", "_QUESTION", "_ASSIGN"}
    | {"_DEFAULT", "RELATION", "_COLON", "_EQUALS", "OPEN_SQUARE", "_ABOUT", "_DOT", "_SCOPE"}
    | {"OPEN_ROUND"}
)
"""What may follow nearly everywhere; named only where nothing else is expected."""


_STARTS = sorted(word for word, terminal in WORDS.items() if terminal not in ("OPERATOR", "FLAG"))


def syntax_error(found: UnexpectedToken, source: SourceText) -> HardwareError:
    """Return the error for a token that does not fit where it stands."""
    token: Token = found.token
    at = token.start_pos or 0
    expected = frozenset(found.interactive_parser.accepts())  # type: ignore[no-untyped-call]
    before = _token_before(source, at)
    if _is_word(token) and "NAME" in expected and "KIND" not in expected:
        return HardwareError(
            f"'{_word(token)}' is a word of SysML v2; expected {_text(expected)}; as a name it has "
            "to stand in single quotes",
            source.location(at),
        )
    if token.type == "$END":
        end = len(source.text.rstrip())
        return HardwareError(
            f"the file ends too early; expected {_text(expected)}", source.location(end)
        )
    if "_SEMICOLON" in expected and before is not None and "\n" in source.text[before:at]:
        return HardwareError(
            f"expected {_text(expected)} at the end of this line, before {_found(token)}",
            source.location(before),
        )
    return HardwareError(
        f"expected {_text(expected)}, found {_found(token)}{_advice(token, expected, source)}",
        source.location(at),
    )


def _is_word(token: Token) -> bool:
    return token.type in ("RESERVED", "SKIPPED") or str(token) in WORDS


def _word(token: Token) -> str:
    return str(token).split(maxsplit=1)[0] if token.type == "SKIPPED" else str(token)


def _advice(token: Token, expected: frozenset[str], source: SourceText) -> str:
    at = token.start_pos or 0
    if token.type == "COMMENT":
        return "; '/* ... */' is an element of its own in SysML v2: use '// ...' within one"
    if str(token) == "==" and "KIND" not in expected:
        return "; a value is given with one '='"
    if str(token) == "," and source.text[at - 1 : at].isdigit() and "_COMMA" not in expected:
        return "; a number has a decimal point, not a comma"
    line = source.text[source.text.rfind("\n", 0, at) + 1 : at].strip()
    near = get_close_matches(line, _STARTS, n=1, cutoff=0.75) if line.isalpha() else []
    return f"; did you mean '{near[0]}'?" if near and line not in WORDS else ""


def _found(token: Token) -> str:
    text = str(token)
    if token.type == "COMMENT":
        return "a comment"
    if token.type == "SKIPPED":
        text = _word(token)
    if len(text) > 40:
        text = text[:37] + "..."
    if token.type == "STRING":
        return f"the text {text}"
    return f"'{text}'" if not text.startswith("'") else f"the name {text}"


def _text(expected: Iterable[str]) -> str:
    """Return what may stand here: a value, an element, or the signs and words themselves."""
    names = set(expected)
    words: list[str] = []
    if names >= _MEMBER:
        words.append("an element such as 'part', 'attribute', 'metadata' or '@'")
        if "_CLOSE" in names:
            words.append("'}'")
        if "$END" in names:
            words.append("the end of the file")
        return _joined(words)
    if names >= _VALUE:
        words.append("a value: a number, a text in double quotes, true, false or a name")
        if "_CLOSE_ROUND" in names:
            words.append("')'")
        return _joined(words)
    plain = sorted(_PLAIN[name] for name in names - _SILENT if name in _PLAIN)
    if "NUMBER" in names:
        plain.insert(0, "a number")
    plain = ["a name"] if "a name" in plain and names & {"_DEF", "LESS"} else plain
    if not plain:
        plain = sorted(_PLAIN[name] for name in names if name in _PLAIN)
    return _joined(plain) if plain else "something else"


def _joined(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"


def _token_before(source: SourceText, at: int) -> int | None:
    """Return the offset behind the token before `at`; `None` where a comment stands between."""
    text = source.text[:at].rstrip()
    line = text[text.rfind("\n") + 1 :]
    return None if "//" in line or text.endswith("*/") or not text else len(text)
