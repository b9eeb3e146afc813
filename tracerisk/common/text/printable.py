"""The one boundary for texts of others: names of files, log lines, exceptions, messages of git.

Terminals and logs of CI only show what passes it; nothing in it moves the cursor, names a window,
fills the clipboard, turns the direction of writing, or is a command of the log.
"""

from __future__ import annotations

import re

MOST_CHARACTERS = 20_000
"""The length up to which a message is printed: an exception of a controller may be endless."""

# Control characters but line feed and tab, what turns the direction of writing, what is invisible,
# what ends lines for some readers alone, and halves of characters, of names that are not UTF-8.
_UNSAFE = (
    "\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\u061c\\u200e\\u200f\\u2028-\\u202e\\u2060-\\u206f"
    "\\ud800-\\udfff\\ufeff\\ufff9-\\ufffb\\U000e0000-\\U000e007f"
)
_CHARACTER = f"[{_UNSAFE}]"
# `::error` of GitHub at the begin of a line; `##[error]` and `##vso[` anywhere.
_COMMAND = r"(?m)^(?=[^\S\n]*::)"
_OLD_COMMAND = r"##(?=\w*\[)"
_ESCAPE = r"\\(?:u(d[89ab]..)\\u(d[c-f]..)|u([0-9a-f]{4})|.)"  # of JSON
_COLOR = r"(\x1b\[[0-9;]*m)"


def printable(text: str) -> str:
    """Return a message as `escaped` does; what is endless is cut."""
    return escaped(cut(text))


def one_line(text: str) -> str:
    """Return a message as `printable` does, on one line: a cell, a title, a caption."""
    return printable(" ".join(text.split()))


def escaped(text: str) -> str:
    """Return a text that a terminal and a log of CI only show, whatever it holds.

    Control characters are escaped, no line begins as a workflow command does (`::error`), and none
    holds one of the older form (`##[error]`). A text that is broken into lines has to be escaped
    afterwards: a command may stand at the begin of a line then.
    """
    if text.isprintable() and "::" not in text and "##" not in text:
        return text  # as most are
    shown = re.sub(_OLD_COMMAND, "# #", without_controls(text))
    return re.sub(_COMMAND, "./", shown)


def without_controls(text: str) -> str:
    """Return a text with control characters as their codes, `\\x1b`; line feeds and tabs stay."""
    return re.sub(_CHARACTER, _code, text)


def escaped_but_colors(text: str) -> str:
    """Return our own tables as `escaped` does, and the colours in them as they are."""
    if "\x1b" not in text:
        return escaped(text)
    # A colour may stand before what would be a command at the begin of a line.
    parts = re.split(_COLOR, text)
    return "".join(part if i % 2 else escaped(part) for i, part in enumerate(parts))


def printable_json(text: str) -> str:
    """Return a JSON text with the same meaning that a terminal and a log of CI only show.

    Within strings alone are there characters that JSON can write by their codes.
    """
    shown = re.sub(_CHARACTER, lambda found: _json_code(found[0]), text)
    return re.sub(_OLD_COMMAND, r"\\u0023#", shown)


def printable_script(text: str) -> str:
    """Return JSON that is ASCII whose strings are those that `without_controls` makes of them.

    What a script shows of it no longer passes any other boundary.
    """
    return re.sub(_ESCAPE, _shown_code, text)


def colorless(text: str) -> str:
    """Return a text without the sequences that colour it, of which the content is the same."""
    return re.sub(_COLOR, "", text)


def cut(text: str) -> str:
    """Return a text of at most `MOST_CHARACTERS`, with how many more there are."""
    left = len(text) - MOST_CHARACTERS
    return text if left <= 0 else f"{text[:MOST_CHARACTERS]} ... and {left} more characters"


def _code(found: re.Match[str]) -> str:
    return ascii(found[0])[1:-1]


def _shown_code(found: re.Match[str]) -> str:
    if found[1]:
        pair = bytes.fromhex(found[1] + found[2]).decode("utf-16-be")
    elif found[3]:
        pair = chr(int(found[3], 16))
    else:
        pair = {"\\b": "\b", "\\f": "\f"}.get(found[0], "")
    shown = without_controls(pair)
    return found[0] if shown == pair else shown.replace("\\", "\\\\")


def _json_code(character: str) -> str:
    code = ord(character)
    if code > 0xFFFF:
        code -= 0x10000
        return f"\\u{0xD800 + (code >> 10):04x}\\u{0xDC00 + (code & 0x3FF):04x}"
    return character if character == "\r" else f"\\u{code:04x}"
