"""What of a C or C++ source is comment, literal or the name of a header, without a parser."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

# For tokens that span lines the pattern matches only the start; the end is found by a search, which
# keeps the time linear. A literal that is not closed ends with its line.
_TOKEN = re.compile(
    rb'(?<![A-Za-z0-9_])(?:u8|u|U|L)?R"(?P<mark>[^()\\\s"]{0,16})\('
    rb'|(?P<block>""")'
    rb'|"(?:\\.|[^"\\\n])*"?'
    rb"|(?<![A-Za-z0-9_])[0-9](?:'?[A-Za-z0-9_.])*"
    rb"|'(?:\\.|[^'\\\n])*'?"
    rb"|//(?:\\\r?\n|[^\n])*"
    rb"|(?P<comment>/\*)",
    re.DOTALL,
)
_INCLUDE = re.compile(rb"^[ \t]*#[ \t]*include[ \t]*[<\"]([^>\"\n]+)[>\"]", re.MULTILINE)
_SPACES = re.compile(rb"[ \t\f\v\r]+")


class Token(NamedTuple):
    """A token that may hold line ends or the signs of comments: a literal, number or comment."""

    start: int
    """The offset of its first byte."""
    end: int
    """The offset behind its last byte."""
    is_comment: bool
    """Whether it is a comment of either form."""
    is_closed: bool = True
    """Whether it has an end; False only of an unterminated `/*` comment."""


def tokens(source: bytes, *, is_java: bool = False) -> Iterator[Token]:
    """Yield comments and literals in the order of the source; of Java text blocks too."""
    at, size = 0, len(source)
    while (matched := _TOKEN.search(source, at)) is not None:
        start, at = matched.span()
        if matched["comment"] is not None:
            end = source.find(b"*/", at)
            at = size if end < 0 else end + 2
            yield Token(start, at, is_comment=True, is_closed=end >= 0)
            continue
        if matched["mark"] is not None:
            close = b")" + matched["mark"] + b'"'
            end = source.find(close, at)
            at = size if end < 0 else end + len(close)
        elif matched["block"] is not None:
            at = _text_block_end(source, at) if is_java else start + 2
        yield Token(start, at, is_comment=source.startswith(b"//", start))


def strings_in(source: bytes) -> Iterator[str]:
    """Yield the plain strings of a C or C++ source, in its order, as they are written."""
    for token in tokens(source):
        text = source[token.start : token.end]
        if not token.is_comment and len(text) > 1 and text[:1] == text[-1:] == b'"':
            yield text[1:-1].decode("utf-8", "replace")


def names_included(source: bytes) -> list[bytes]:
    """Return the names of headers that a C or C++ source includes, in its order."""
    return _INCLUDE.findall(source)


def _text_block_end(source: bytes, at: int) -> int:
    while (end := source.find(b'"""', at)) > 0 and source[end - 1 : end] == b"\\":
        at = end + 1
    return len(source) if end < 0 else end + 3


def code_of(source: bytes) -> bytes:
    """Return what a source says: without comments, blank lines and spaces between words."""
    parts, plain, at = [], [], 0
    for token in tokens(source):
        plain.append(source[at : token.start])
        if token.is_comment:
            plain.append(b" ")
        else:
            parts += [_squeezed(b"".join(plain)), source[token.start : token.end]]
            plain = []
        at = token.end
    return b"".join([*parts, _squeezed(b"".join([*plain, source[at:]]))]).strip()


def _squeezed(text: bytes) -> bytes:
    """Return text with single spaces; where a line ends stays, for it matters to directives."""
    first, *rest = _SPACES.sub(b" ", text).split(b"\n")
    if not rest:
        return first
    inner = [line for chunk in rest[:-1] if (line := chunk.strip(b" "))]
    return b"\n".join([first.rstrip(b" "), *inner, rest[-1].lstrip(b" ")])
