"""Loggers: lines on standard error with severity, simulated time and the logger's name."""

from __future__ import annotations

import sys
from typing import Any

from tracerisk.ros.controller.frames import controller_frame
from tracerisk.ros.graph.failures import error_logged
from tracerisk.ros.time.clock import EPOCH_NS

from ._run import run
from .impl.logging_severity import LoggingSeverity

_SEPARATOR = "."
_FILTERS = {
    "throttle_duration_sec",
    "throttle_time_source_type",
    "skip_first",
    "once",
    "name",
}


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

    def log(self, message: Any, severity: Any, **kwargs: Any) -> bool:
        """Log a line, and tell whether it was.

        `once`, `skip_first` and `throttle_duration_sec` [s] count for the line of code.

        Raises:
            TypeError: a keyword is not known.
        """
        unknown = sorted(set(kwargs) - _FILTERS)
        if unknown:
            raise TypeError(
                f"parameter '{unknown[0]}' is not one of the recognized logging options"
            )
        level = LoggingSeverity(severity)
        if not self.is_enabled_for(level) or not self._passes(kwargs):
            return False
        state = run()
        seconds, rest = divmod(EPOCH_NS + state.scheduler.now_ns, 1_000_000_000)
        print(  # noqa: T201 - this is its purpose
            f"[{level.name}] [{seconds}.{rest:09d}] [{self.name}]: {message}", file=sys.stderr
        )
        self._publish_to_rosout(level, str(message))
        if level >= LoggingSeverity.ERROR:
            error_logged(level.name, str(message))
        return True

    def _passes(self, filters: dict[str, Any]) -> bool:
        if not filters:
            return True
        frame = controller_frame()
        place = None if frame is None else (frame.f_code.co_filename, frame.f_lineno)
        seen, now_ns = run().log_places, run().scheduler.now_ns
        passes = True
        if filters.get("once"):
            passes = seen.setdefault((place, "once"), 0) == 0
            seen[place, "once"] = 1
        if filters.get("skip_first"):
            passes = passes and (place, "skip_first") in seen
            seen[place, "skip_first"] = 1
        period = filters.get("throttle_duration_sec")
        if period and passes:
            last_ns = seen.get((place, "throttle"))
            passes = last_ns is None or now_ns - last_ns >= period * 1e9
            if passes:
                seen[place, "throttle"] = now_ns
        return passes

    def _publish_to_rosout(self, level: LoggingSeverity, text: str) -> None:
        state = run()
        if not state.graph.subscriptions("/rosout"):
            return
        from rcl_interfaces.msg import Log

        if state.rosout is None:
            state.rosout = state.graph.advertise(
                "/rosout", Log._ros_type, node=self.name, copy=lambda message: message
            )
        line = Log(level=int(level), name=self.name, msg=text)
        stamp_ns = EPOCH_NS + state.scheduler.now_ns
        line.stamp.sec, line.stamp.nanosec = divmod(stamp_ns, 1_000_000_000)
        state.rosout.publish(line)

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
