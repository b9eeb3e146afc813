"""The words of a ROS command line that a text holds."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence

_MOST_LINES = 60  # of one command, with the message that it holds
_LONGEST = 8000  # characters of one: a longer text is data, and takes seconds to be read as words
_NAMED = 1  # words before those that may be numbers: the verb and the name
_TAKES = frozenset({"-r", "--rate", "-n", "--node-name", "-t", "--times", "-w", "-p", "-s"})
_ENDS_COMMAND = frozenset({"&&", "||", ";", "|", "&", ">", ">>", "#"})


def command_words(lines: Sequence[str], number: int, start: int) -> tuple[str, ...]:
    """Return the words of a command that begins on a line, and may go on over the next ones."""
    text = lines[number][start:].rstrip()
    indent = len(lines[number]) - len(lines[number].lstrip())
    # The quote or tick in which a text holds the command ends it too.
    before = lines[number][start - 1 : start] if start else ""
    if before in ("`", '"', "'") and before in text:
        text = text[: text.index(before)] if before == "`" else text
    quote, added = "", text
    for more in range(number + 1, min(number + 1 + _MOST_LINES, len(lines) + 1)):
        if len(text) > _LONGEST:
            break
        words: list[str] = []
        if quote in added:
            words, quote = _read(text.rstrip("\\"))
        if words and not text.endswith("\\"):
            end = next((at for at, word in enumerate(words) if word in _ENDS_COMMAND), len(words))
            return tuple(words[:end])
        if more >= len(lines):
            break
        # A message that goes on over lines is as far in as the command itself.
        following = lines[more].rstrip()
        following = following[min(indent, len(following) - len(following.lstrip())) :]
        if text.endswith("\\"):
            text = f"{text[:-1].rstrip()} {following.strip()}"
        else:
            text = f"{text}\n{following}"
        added = following
    return ()


def _read(text: str) -> tuple[list[str], str]:
    """Return the words of a command, or none and the quote that is not closed in it."""
    lexer = shlex.shlex(text, posix=True, punctuation_chars=False)
    lexer.whitespace_split, lexer.commenters = True, "#"
    try:
        return list(lexer), ""
    except ValueError:
        state = getattr(lexer, "state", "")  # the quote in which it stopped
        return [], state if state in ("'", '"') else ""


def positional_words(words: Sequence[str]) -> tuple[str, ...]:
    """Return the verb of a command of ROS and what follows it, without options."""
    verbs = {"pub", "call", "send_goal", "set"}
    at = next((at for at, word in enumerate(words) if word in verbs), None)
    if at is None:
        return ()
    positional: list[str] = []
    rest = iter(words[at:])
    for word in rest:
        if word in _TAKES and len(positional) < 4:
            next(rest, None)
        elif not word.startswith("-") or (len(positional) > _NAMED and re.match(r"-[\d.]", word)):
            # `-1` before the name is an option, behind it a number.
            positional.append(word)
    return tuple(positional)


def is_named(written: str, full: str) -> bool:
    """Return whether a name that a text holds is the end of a full name."""
    plain = written.strip("/~")
    return bool(plain) and f"/{full.strip('/~')}".endswith(f"/{plain}")
