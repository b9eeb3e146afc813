"""What of a C or C++ source is comment or literal, told without a parser."""

from __future__ import annotations

import re
from pathlib import PurePath

C_SUFFIXES = frozenset({".c", ".h"})
CPP_SUFFIXES = frozenset({".cc", ".cpp", ".cxx", ".c++", ".hh", ".hpp", ".hxx", ".ino"})

TOKEN = re.compile(
    rb'(?<![A-Za-z0-9_])(?:u8|u|U|L)?R"(?P<mark>[^()\\\s]{0,16})\(.*?\)(?P=mark)"'
    rb'|"""(?:\\.|[^\\])*?"""'
    rb'|"(?:\\.|[^"\\\n])*"'
    rb"|(?<![A-Za-z0-9_])[0-9](?:'?[A-Za-z0-9_.])*"
    rb"|'(?:\\.|[^'\\\n])*'"
    rb"|//(?:\\\r?\n|[^\n])*"
    rb"|/\*(?P<comment>.*?)\*/"
    rb"|/\*(?P<unclosed>.*)",
    re.DOTALL,
)
"""What may hold line ends or the signs of comments: literals (raw strings of C++ and text blocks
of Java among them), numbers with separators, and comments."""

# Where a line ends matters to directives.
_LINES = re.compile(rb"\s*\n\s*")
_SPACES = re.compile(rb"[ \t\f\v\r]+")


def is_c(file: str) -> bool:
    """Whether a file is C or C++ by its ending."""
    return PurePath(file).suffix.lower() in C_SUFFIXES | CPP_SUFFIXES


def code_of(source: bytes) -> bytes:
    """Return what a source says: without comments, blank lines and spaces between words."""
    bare = TOKEN.sub(lambda found: b" " if _is_comment(found[0]) else found[0], source)
    parts, at = [], 0
    for found in TOKEN.finditer(bare):
        parts += [_squeezed(bare[at : found.start()]), found[0]]
        at = found.end()
    return b"".join([*parts, _squeezed(bare[at:])]).strip()


def _is_comment(token: bytes) -> bool:
    return token.startswith((b"//", b"/*"))


def _squeezed(text: bytes) -> bytes:
    return _SPACES.sub(b" ", _LINES.sub(b"\n", text))
