"""A digest of what a source says: comments, blank lines and spaces between words left out.

It is made of the text and not of Python's own tokens or syntax tree, which differ from one
version of Python to the next: a team's lock must say the same on each of their machines.
"""

from __future__ import annotations

import re

from tracerisk.common.text.digests import sha256
from tracerisk.instrument.source.language import is_c

# A comment behind an f-string is kept: since Python 3.12 quotes may nest in one, and what looks
# like a comment there may be text.
# The letters before a string are plain text here, where no space is squeezed out of them: each
# part begins with a quote or a hash, which the search finds fast.
_PART = re.compile(
    rb"(?P<string>"
    rb'"""(?:\\.|[^\\])*?"""|'
    rb"'''(?:\\.|[^\\])*?'''|"
    rb'"(?:\\.|[^"\\\n])*"|'
    rb"'(?:\\.|[^'\\\n])*')"
    rb"|(?P<comment>\#[^\n]*)",
    re.DOTALL,
)
_SPACES = re.compile(rb"(?<=[^ \t\f\n])[ \t\f]+")
_BLANK = re.compile(rb"(?:[ \t\f]*\n)+")
_F_STRING = re.compile(rb"[rR]?[fF][rR]?['\"]")


def code_digest(source: bytes, file: str) -> str:
    """Return the digest of a source; the same for line ends of any kind.

    The suffix of `file` says whether it is C or C++; all else is Python.
    """
    if is_c(file):
        from tracerisk.instrument.source.c_tokens import code_of

        return sha256(code_of(source))
    text = source.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    parts = []
    # A line begins here too, so that blank ones above the first say nothing.
    plain = [b"\n"]
    at = 0
    for match_ in _PART.finditer(text):
        plain.append(text[at : match_.start()])
        at = match_.end()
        if match_["string"] is not None:
            parts += [_squeezed(b"".join(plain)), match_["string"]]
            plain = []
        elif _F_STRING.search(text, text.rfind(b"\n", 0, match_.start()) + 1, match_.start()):
            plain.append(match_["comment"])
    parts.append(_squeezed(b"".join([*plain, text[at:], b"\n"])))
    return sha256(b"".join(parts))


def _squeezed(text: bytes) -> bytes:
    return _SPACES.sub(b" ", _BLANK.sub(b"\n", text))
