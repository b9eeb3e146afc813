"""Where smach writes its messages, and how it knows that the program is to end."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

Log = Callable[..., Any]


def _on_stdout(level: str) -> Log:
    def log(message: object, *args: object) -> None:
        text = str(message) % args if args else str(message)
        sys.stdout.write(f"[{level:^7}] : {text}\n")

    return log


_LOGGERS: dict[str, Log] = {
    "info": _on_stdout("INFO"),
    "warn": _on_stdout("WARN"),
    "debug": lambda *args: None,
    "error": _on_stdout("ERROR"),
}
_IS_SHUTDOWN: list[Callable[[], bool]] = [lambda: False]


def loginfo(message: object, *args: object) -> None:
    """Write a message."""
    _LOGGERS["info"](message, *args)


def logwarn(message: object, *args: object) -> None:
    """Write a warning."""
    _LOGGERS["warn"](message, *args)


def logdebug(message: object, *args: object) -> None:
    """Write what only developers want to read."""
    _LOGGERS["debug"](message, *args)


def logerr(message: object, *args: object) -> None:
    """Write an error."""
    _LOGGERS["error"](message, *args)


def set_loggers(info: Log, warn: Log, debug: Log, error: Log) -> None:
    """Set the functions that write messages."""
    _LOGGERS.update(info=info, warn=warn, debug=debug, error=error)


def set_shutdown_check(cb: Callable[[], bool]) -> None:
    """Set the function that says whether the program is to end."""
    _IS_SHUTDOWN[:] = [cb]


def is_shutdown() -> bool:
    """Return whether the program is to end: states are not left for others then."""
    return _IS_SHUTDOWN[0]()
