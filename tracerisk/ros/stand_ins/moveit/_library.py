"""What the library's classes share in one run: the server, the robot model, the messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rclpy.logging import get_logger

from tracerisk.ros.graph.runtime import Runtime, current
from tracerisk.ros.moveit.messages import new_message
from tracerisk.ros.moveit.move_group import MoveGroupServer

if TYPE_CHECKING:
    from typing_extensions import Self

    from .core.robot_model import RobotModel

new = new_message


class Library:
    """The state of the library; `library()` gives that of the run that is active."""

    def __init__(self, runtime: Runtime) -> None:
        self.scheduler = runtime.scheduler
        self.tracer: Any = runtime.tracer
        self.server = runtime.client(MoveGroupServer)
        self.model: RobotModel | None = None


class HandedOut:
    """Base of what the library hands to programs, none of which they can make."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        module = type(self).__module__.partition("._")[0]
        raise TypeError(f"{module}.{type(self).__name__}: No constructor defined!")

    @classmethod
    def _of(cls, **parts: Any) -> Self:
        made = cls.__new__(cls)
        vars(made).update(parts)
        return made


def library() -> Library:
    """Return the library's state.

    Raises:
        RuntimeError: no controller is being run.
    """
    return current().client(Library)


def log_error(message: str) -> None:
    """Log an error as the real library does where it only answers that it failed."""
    get_logger("moveit_py").error(message)
