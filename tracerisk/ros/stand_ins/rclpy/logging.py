"""Loggers by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tracerisk.ros.imports.exported import defined as _defined

from ._logger import RcutilsLogger
from ._run import run
from .impl.logging_severity import LoggingSeverity

_root_logger = RcutilsLogger()


def get_logger(name: str) -> RcutilsLogger:
    """Return the logger of a name.

    Raises:
        ValueError: the name is empty.
    """
    if not name:
        raise ValueError("Logger name must not be empty.")
    return _root_logger.get_child(name)


def initialize() -> None:
    """Begin to log; nothing has to be done."""


def shutdown() -> None:
    """End logging; nothing has to be done."""


def clear_config() -> None:
    """Forget the levels that were set."""
    run().log_levels = {"": int(LoggingSeverity.INFO)}


def set_logger_level(name: str, level: Any, detailed_error: bool = False) -> None:
    """Log nothing of the logger `name` below `level`."""
    run().log_levels[name] = int(LoggingSeverity(level))


def get_logger_level(name: str) -> LoggingSeverity:
    """Return the level that was set for a logger."""
    return LoggingSeverity(run().log_levels.get(name, 0))


def get_logger_effective_level(name: str) -> LoggingSeverity:
    """Return the level of a logger, or of the nearest above that has one."""
    return RcutilsLogger(name).get_effective_level()


def get_logging_severity_from_string(log_severity: str) -> LoggingSeverity:
    """Return the severity of a name.

    Raises:
        RuntimeError: there is none of that name.
    """
    try:
        return LoggingSeverity[log_severity.upper()]
    except KeyError:
        raise RuntimeError(
            f"no logging severity '{log_severity}'; there are "
            f"{', '.join(logging_severity.name for logging_severity in LoggingSeverity)}"
        ) from None


def get_logging_directory() -> Path:
    """Return where the real library writes its files; this one writes none."""
    return Path.home() / ".ros" / "log"


__all__ = _defined(globals(), "LoggingSeverity")
