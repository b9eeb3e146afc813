"""Stand-in for the compiled half of rclpy: the errors and enumerations that are taken from it."""

from __future__ import annotations

from enum import Enum

from tracerisk.ros.imports.exported import defined as _defined

from .exceptions import InvalidHandle  # noqa: F401 - names of this module too


def rclpy_get_rmw_implementation_identifier() -> str:
    """Return the name of the middleware: there is none but the simulation."""
    return "rmw_tracerisk"


class RCLError(RuntimeError):
    """An operation of the library below failed."""


class NodeNameNonExistentError(RCLError):
    """No node of the name exists."""


class RCLInvalidROSArgsError(RCLError):
    """Arguments for ROS are malformed."""


class UnknownROSArgsError(RuntimeError):
    """There are arguments for ROS that it does not know."""


class UnsupportedEventTypeError(RCLError):
    """The middleware has no such event."""


class TransitionCallbackReturnType(Enum):
    """How a transition of a lifecycle node went; the numbers are those of lifecycle_msgs."""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99

    def to_label(self) -> str:
        """Return the label of the transition that follows."""
        return f"transition_{self.name.lower()}"


class GoalEvent(Enum):
    """What moves a goal of a server to another state; the numbers are those of rcl_action."""

    EXECUTE = 0
    CANCEL_GOAL = 1
    SUCCEED = 2
    ABORT = 3
    CANCELED = 4


__all__ = _defined(globals(), "InvalidHandle")
