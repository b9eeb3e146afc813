"""The handler by which programs send records of `logging` to the terminal as ROS does."""

from __future__ import annotations

import logging
import sys
import time
from typing import TextIO

__all__ = ["RosStreamHandler"]

_SEVERITIES = {"WARNING": "WARN", "CRITICAL": "FATAL"}
_TEXT = logging.Formatter("%(message)s")


class RosStreamHandler(logging.Handler):
    """Writes records below a warning to `stdout`, all others to `stderr`; never in colours."""

    def __init__(
        self, colorize: bool = True, stdout: TextIO | None = None, stderr: TextIO | None = None
    ) -> None:
        super().__init__()
        self._stdout = sys.stdout if stdout is None else stdout
        self._stderr = sys.stderr if stderr is None else stderr

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record as a line: its severity, the time and the message."""
        severity = _SEVERITIES.get(record.levelname, record.levelname)
        stream = self._stdout if record.levelno < logging.WARNING else self._stderr
        stream.write(f"[{severity}] [{time.time():f}]: {_TEXT.format(record)}\n")
