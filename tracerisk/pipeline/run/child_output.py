"""What the process of a run prints, passed on to our standard error."""

from __future__ import annotations

import codecs
import contextlib
import json
import os
import re
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, TextIO

from tracerisk.common.text.bounded import file_bytes
from tracerisk.common.text.printable import colorless, escaped
from tracerisk.errors import Location
from tracerisk.pipeline.trace.run_files import MOST_TEXT
from tracerisk.ros.controller.thread import RunOver

_STACK_LINE = re.compile(r'  File "(?P<file>.*)", line (?P<line>\d+) in ')
_WAIT = "Waits for a program: "
_END_OF_OUTPUT = 2000  # bytes that are kept of it
_MOST_AT_ONCE = 65536
_MOST_HELD = 1000  # characters; what is longer is blanks
# What may go on in the next part: a colour or a line end, a command of the older form.
_BEGUN_CODE = re.compile(r"(?:\r|\x1b(?:\[[0-9;]{0,30})?)\Z")
_BEGUN_COMMAND = re.compile(r"#{1,2}\w{0,20}\Z")


class PassingOn(threading.Thread):
    """Prints what a controller prints, at once, or line by line where progress is drawn.

    `is_drawn`: what draws the progress has taken hold of `sys.stderr`. A pipe either way, so that
    a controller sees no terminal, whoever started it. `is_shown`: else it is only read.
    """

    def __init__(self, output: IO[bytes], *, is_drawn: bool, is_shown: bool = True) -> None:
        super().__init__(daemon=True)
        self._output = output
        self._is_drawn = is_drawn
        self._is_shown = is_shown
        self._end = b""

    @property
    def last_line(self) -> str:
        """The last line that was printed and is no blank one; whole only where it is short."""
        lines = self._end.decode("utf-8", "replace").strip().splitlines()
        return lines[-1] if lines else ""

    def run(self) -> None:
        """Print until the output ends."""
        target = sys.stderr.fileno() if _has_descriptor(sys.stderr) else None
        shown = PrintableParts()
        with self._output:
            for part in self._parts():
                self._end = (self._end + part)[-_END_OF_OUTPUT:]
                if self._is_shown:
                    self._print(shown.of(part), target)
        if self._is_shown:
            self._print(shown.rest(), target)

    def _print(self, text: str, target: int | None) -> None:
        if self._is_drawn:
            # Looked up each time: what draws the progress takes its place while it draws.
            sys.stderr.write(text)
            sys.stderr.flush()
        elif target is not None:
            _write_all(target, text.encode())

    def _parts(self) -> Iterator[bytes]:
        if self._is_drawn:
            while line := self._output.readline(_MOST_AT_ONCE):
                yield line
            return
        while part := os.read(self._output.fileno(), _MOST_AT_ONCE):
            yield part


class PrintableParts:
    """Makes the output of a controller printable, part by part, as `escaped` does of a whole text.

    Colours are left out, and a carriage return ends a line as a line feed does. The end of a part
    is held back while it may be the begin of a command.
    """

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        self._raw = ""
        self._plain = ""
        self._is_within_line = False

    def of(self, part: bytes) -> str:
        """Return what may be printed now."""
        plain = self._without_colors(self._decoder.decode(part))
        end = _BEGUN_COMMAND.search(plain)
        begin = len(plain) if end is None else end.start()
        line = plain.rfind("\n") + 1
        if plain[line:].strip() in ("", ":") and not (self._is_within_line and not line):
            begin = min(begin, line)
        self._plain = plain[begin:][:_MOST_HELD]
        return self._shown(plain[:begin])

    def rest(self) -> str:
        """Return what is left when the output ends."""
        plain = self._without_colors(self._decoder.decode(b"", final=True), is_end=True)
        return self._shown(plain)

    def _without_colors(self, text: str, *, is_end: bool = False) -> str:
        """Return what was held back of the text, and what is new of it."""
        text = self._raw + text
        end = None if is_end else _BEGUN_CODE.search(text)
        begin = len(text) if end is None else end.start()
        self._raw = text[begin:]
        shown = colorless(text[:begin]).replace("\r\n", "\n").replace("\r", "\n")
        return self._plain + shown

    def _shown(self, plain: str) -> str:
        if not plain:
            return ""
        # What goes on with a line is no begin of one.
        before = "x" if self._is_within_line else ""
        self._is_within_line = not plain.endswith("\n")
        return escaped(before + plain)[len(before) :]


def _write_all(descriptor: int, data: bytes) -> None:
    with contextlib.suppress(OSError):
        while data:
            data = data[os.write(descriptor, data) :]


def _has_descriptor(stream: Any) -> bool:
    try:
        stream.fileno()
    except (AttributeError, OSError, ValueError):
        return False
    return True


def tell_wait(stacks: TextIO, over: RunOver | None) -> None:
    """Write in the child, where its stacks go, what it waits for in real time; None: nothing."""
    if over is not None or stacks.tell():
        stacks.seek(0)
        stacks.truncate()
    if over is not None:
        place = over.location
        told = [over.message, None if place is None else [place.file, place.line]]
        stacks.write(f"{_WAIT}{json.dumps(told)}\n\n")
        stacks.flush()


def stopped_at(stacks: Path, root: Path, limit: str) -> tuple[str, Location | None]:
    """Return how a limit ended the child, in words, and where its controller stood.

    That is the wait for a program that the child reported, or else the innermost place among the
    stacks that it sent.
    """
    try:
        text = file_bytes(stacks, MOST_TEXT, through_links=False).decode(errors="replace")
    except OSError:
        return limit, None
    if text.startswith(_WAIT):
        with contextlib.suppress(ValueError, TypeError):
            words, place = json.loads(text.partition("\n")[0].removeprefix(_WAIT))
            return f"{words}: {limit}", None if place is None else Location(*place)
    return limit, _place_in(text, root)


def _place_in(text: str, root: Path) -> Location | None:
    threads = text.split("\n\n")
    current = [name for name in threads if name.startswith("Current thread")]
    for thread in [*current, *threads]:
        for line in thread.splitlines():
            matched = _STACK_LINE.match(line)
            if matched is not None and Path(matched["file"]).is_relative_to(root):
                file = Path(matched["file"]).relative_to(root).as_posix()
                return Location(file, int(matched["line"]))
    return None
