"""Services by which others read and set the levels of loggers."""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import LoggerLevel, SetLoggerLevelsResult
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels

from .logging import get_logger_level, set_logger_level


class LoggingService:
    """Serves `NODE/get_logger_levels` and `NODE/set_logger_levels`."""

    def __init__(self, node: Any) -> None:
        for srv_type, name, callback in (
            (GetLoggerLevels, "get_logger_levels", self._get_logger_levels),
            (SetLoggerLevels, "set_logger_levels", self._set_logger_levels),
        ):
            node._create_own_service(srv_type, f"~/{name}", callback)

    def _get_logger_levels(self, request: Any, response: Any) -> Any:
        response.levels = [
            LoggerLevel(name=name, level=int(get_logger_level(name))) for name in request.names
        ]
        return response

    def _set_logger_levels(self, request: Any, response: Any) -> Any:
        for level in request.levels:
            result = SetLoggerLevelsResult(successful=True)
            try:
                set_logger_level(level.name, level.level, detailed_error=True)
            except ValueError:
                result.successful, result.reason = False, "Failed reason: Invalid logger level."
            response.results.append(result)
        return response
