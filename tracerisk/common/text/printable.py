"""Texts of others - names of files, of exceptions, of parts - as a terminal only shows them."""

from __future__ import annotations

import re

MOST_CHARACTERS = 20_000
"""The length up to which a message is printed: an exception of a controller may be endless."""

# Control characters but line feed and tab, and those that turn the direction of writing.
_UNSAFE = r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
_COMMAND = r"(?m)^(?=\s*(?:::|##\[))"


def printable(text: str) -> str:
    """Return a message that a terminal and a log of CI only show.

    Names of files and texts of exceptions are others': control characters are escaped, no line
    begins as a workflow command does (`::error`, `##[error]`), and what is endless is cut.
    """
    shown = cut(text)
    if shown.isprintable() and "::" not in shown and "##[" not in shown:
        return shown  # as most are, for which no expression need be compiled
    escaped = re.sub(_UNSAFE, lambda found: ascii(found[0])[1:-1], shown)
    return re.sub(_COMMAND, "./", escaped)


def cut(text: str) -> str:
    """Return a text of at most `MOST_CHARACTERS`, with how many more there are."""
    left = len(text) - MOST_CHARACTERS
    return text if left <= 0 else f"{text[:MOST_CHARACTERS]} ... and {left} more characters"
