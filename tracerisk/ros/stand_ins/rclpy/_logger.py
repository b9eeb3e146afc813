"""Loggers: lines on standard error with severity, simulated time and the logger's name."""

from __future__ import annotations

import sys
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from tracerisk.ros.controller.frames import caller_beyond
from tracerisk.ros.graph.failures import trouble_logged
from tracerisk.ros.time.clock import EPOCH_NS

from ._run import run
from .impl.logging_severity import LoggingSeverity

_SEPARATOR = "."
_FILTERS = {
    "throttle": ("throttle_duration_sec", "throttle_time_source_type"),
    "skip_first": ("skip_first",),
    "once": ("once",),
}
"""The filters in the order in which they are asked, each with its keywords."""
_KEYWORDS = [keyword for keywords in _FILTERS.values() for keyword in keywords]
_OWN_FILES = ("rclpy/_logger.py", "rclpy/logging.py")


@dataclass(slots=True)
class _Place:
    """The state of a place in the source that logs, set by its first call."""

    severity: LoggingSeverity
    """The severity of its lines."""
    name: str
    """The name of its logger."""
    filters: dict[str, Any]
    """The filters of the call, such as `once`, by keyword."""
    throttled_ns: int = 0
    """The time of the last line that passed the throttle [ns]."""
    was_skipped: bool = False
    """Whether the first line was skipped."""
    was_logged: bool = False
    """Whether a line was logged."""


class RcutilsLogger:
    """A logger by name; children inherit its level."""

    def __init__(self, name: str = "") -> None:
        self.name = name

    def get_child(self, name: str) -> RcutilsLogger:
        """Return the logger `name` below this one.

        Raises:
            ValueError: the name is empty.
        """
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return RcutilsLogger(f"{self.name}{_SEPARATOR}{name}" if self.name else name)

    def set_level(self, level: Any) -> None:
        """Log nothing below `level`."""
        run().log_levels[self.name] = int(LoggingSeverity(level))

    def get_effective_level(self) -> LoggingSeverity:
        """Return the level of the logger, or of the nearest above that has one."""
        levels, name = run().log_levels, self.name
        while name and not levels.get(name):
            name = name.rpartition(_SEPARATOR)[0]
        return LoggingSeverity(levels.get(name) or levels[""])

    def is_enabled_for(self, severity: Any) -> bool:
        """Return whether lines of a severity are logged."""
        return LoggingSeverity(severity) >= self.get_effective_level()

    def log(self, message: Any, severity: Any, name: str | None = None, **kwargs: Any) -> bool:
        """Log a line, and return whether it was.

        `once`, `skip_first` and `throttle_duration_sec` [s] count for the place in the source.

        Raises:
            TypeError: a keyword is not known, or is of no use without another; or the message is
                no string.
            ValueError: the same place has logged with another severity, name or filter.
        """
        level = LoggingSeverity(severity)
        if not self.is_enabled_for(level):
            return False
        given_name = self.name if name is None else name
        place = self._place(level, given_name, _filters(kwargs))
        if not _passes(place):
            return False
        message = _text_for_c(message)
        state = run()
        seconds, rest = divmod(EPOCH_NS + state.scheduler.now_ns, 1_000_000_000)
        print(  # noqa: T201 - this is its purpose
            f"[{level.name}] [{seconds}.{rest:09d}] [{given_name}]: {message}", file=sys.stderr
        )
        self._publish_to_rosout(level, message)
        if level >= LoggingSeverity.WARN:
            trouble_logged(level.name, message)
        return True

    def _place(self, level: LoggingSeverity, name: str, filters: dict[str, Any]) -> _Place:
        frame = caller_beyond(_OWN_FILES)
        key = None if frame is None else (frame.f_code.co_filename, frame.f_lineno, frame.f_lasti)
        known: _Place = run().log_places.setdefault((self.name, key), _Place(level, name, filters))
        for what, was, now in (
            ("Logger severity", known.severity, level),
            ("Logger name", known.name, name),
            ("Requested logging filters", set(known.filters), set(filters)),
            ("Logging filter parameters", known.filters, filters),
        ):
            if was != now:
                raise ValueError(f"{what} cannot be changed between calls.")
        return known

    def _publish_to_rosout(self, level: LoggingSeverity, text: str) -> None:
        state = run()
        if self.name in state.unheard_loggers or not state.graph.subscriptions("/rosout"):
            return
        from rcl_interfaces.msg import Log

        line = Log(level=int(level), name=self.name, msg=text)
        stamp_ns = EPOCH_NS + state.scheduler.now_ns
        line.stamp.sec, line.stamp.nanosec = divmod(stamp_ns, 1_000_000_000)
        if state.rosout is None:
            # The line of a logger of no node.
            state.rosout = state.graph.advertise(
                "/rosout", Log._ros_type, node=self.name, copy=lambda message: message
            )
        (state.rosouts.get(self.name) or state.rosout).publish(line)

    def debug(self, message: Any, **kwargs: Any) -> bool:
        """Log a line of severity DEBUG; see `log`."""
        return self.log(message, LoggingSeverity.DEBUG, **kwargs)

    def info(self, message: Any, **kwargs: Any) -> bool:
        """Log a line of severity INFO; see `log`."""
        return self.log(message, LoggingSeverity.INFO, **kwargs)

    def warning(self, message: Any, **kwargs: Any) -> bool:
        """Log a line of severity WARN; see `log`."""
        return self.log(message, LoggingSeverity.WARN, **kwargs)

    def warn(self, message: Any, **kwargs: Any) -> bool:
        """Log a line of severity WARN; see `log`."""
        return self.log(message, LoggingSeverity.WARN, **kwargs)

    def error(self, message: Any, **kwargs: Any) -> bool:
        """Log a line of severity ERROR; see `log`."""
        return self.log(message, LoggingSeverity.ERROR, **kwargs)

    def fatal(self, message: Any, **kwargs: Any) -> bool:
        """Log a line of severity FATAL; see `log`."""
        return self.log(message, LoggingSeverity.FATAL, **kwargs)


def _text_for_c(message: Any) -> str:
    """Return what C logs of a message: a text up to its first zero; of None `(null)`.

    Raises:
        TypeError: it is neither text nor bytes, or holds what UTF-8 has not.
    """
    if message is None:
        return "(null)"
    with suppress(UnicodeError):
        if isinstance(message, str):
            return message.encode().decode().partition("\0")[0]
        if isinstance(message, bytes | bytearray):
            return bytes(message).decode(errors="replace").partition("\0")[0]
    raise TypeError(
        "rclpy_logging_rcutils_log(): incompatible function arguments: the message is a "
        f"{type(message).__name__} ({message!r}) and must be a str"
    )


def _filters(keywords: dict[str, Any]) -> dict[str, Any]:
    """Return the keywords of the filters that are asked for."""
    unknown = sorted(set(keywords) - set(_KEYWORDS))
    if unknown:
        raise TypeError(
            f'parameter "{unknown[0]}" is not one of the recognized logging options "{_KEYWORDS}"'
        )
    filters: dict[str, Any] = {}
    for kind, (needed, *others) in _FILTERS.items():
        if not any(keywords.get(other) for other in (needed, *others)):
            continue
        if needed not in keywords:
            raise TypeError(
                f'required parameter "{needed}" not specified but is required for the logging '
                f'filter "{kind}"'
            )
        filters |= {other: keywords.get(other) for other in (needed, *others)}
    return filters


def _passes(place: _Place) -> bool:
    """Return whether the filters of a place let a line pass, and note that one came."""
    filters = place.filters
    if "throttle_duration_sec" in filters:
        clock = filters["throttle_time_source_type"]
        now_ns = EPOCH_NS + run().scheduler.now_ns if clock is None else clock._reported_ns
        if now_ns < place.throttled_ns + filters["throttle_duration_sec"] * 1e9:
            return False
        place.throttled_ns = now_ns
    if "skip_first" in filters and not place.was_skipped:
        place.was_skipped = True
        return False
    if "once" in filters and place.was_logged:
        return False
    place.was_logged = True
    return True
