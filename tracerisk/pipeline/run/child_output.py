"""What the process of a run prints, passed on to our standard error."""

from __future__ import annotations

import contextlib
import os
import re
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

from tracerisk.common.sandbox.process import read_regular
from tracerisk.errors import Location
from tracerisk.pipeline.trace.run_files import MOST_TEXT

_STACK_LINE = re.compile(r'  File "(?P<file>.*)", line (?P<line>\d+) in ')
_END_OF_OUTPUT = 2000  # bytes that are kept of it


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
        with self._output:
            for part in self._parts():
                self._end = (self._end + part)[-_END_OF_OUTPUT:]
                if not self._is_shown:
                    continue
                if self._is_drawn:
                    # Looked up each time: what draws the progress takes its place while it draws.
                    sys.stderr.write(part.decode("utf-8", "replace"))
                    sys.stderr.flush()
                elif target is not None:
                    _write_all(target, part)

    def _parts(self) -> Iterator[bytes]:
        if self._is_drawn:
            yield from self._output
            return
        while part := os.read(self._output.fileno(), 65536):
            yield part


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


def place_in(stacks: Path, root: Path) -> Location | None:
    """Return the innermost place of the controller among the stacks that the child sent."""
    try:
        text = read_regular(stacks, MOST_TEXT).decode(errors="replace")
    except OSError:
        return None
    threads = text.split("\n\n")
    current = [name for name in threads if name.startswith("Current thread")]
    for thread in [*current, *threads]:
        for line in thread.splitlines():
            matched = _STACK_LINE.match(line)
            if matched is not None and Path(matched["file"]).is_relative_to(root):
                file = Path(matched["file"]).relative_to(root).as_posix()
                return Location(file, int(matched["line"]))
    return None
