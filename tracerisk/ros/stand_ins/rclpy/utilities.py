"""Functions that look at a context, and the default one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tracerisk.ros.imports.exported import defined as _defined

from ._arguments import without_ros_arguments
from ._rclpy_pybind11 import rclpy_get_rmw_implementation_identifier
from ._run import run
from .constants import S_TO_NS
from .context import Context


def get_default_context(*, shutting_down: bool = False) -> Context:
    """Return the context that is used where none is given; `shutting_down` gives up that one."""
    state = run()
    context = state.default_context
    if shutting_down:
        state.default_context = Context()
    return context


def remove_ros_args(args: Sequence[str] | None = None) -> list[str]:
    """Return a command line, by default the program's own, without what is meant for ROS."""
    return without_ros_arguments(run().runtime.argv if args is None else args)


def ok(*, context: Context | None = None) -> bool:
    """Return whether a context lives."""
    return (get_default_context() if context is None else context).ok()


def shutdown(*, context: Context | None = None) -> None:
    """End a context.

    Raises:
        RuntimeError: it has not begun, or has ended already.
    """
    (get_default_context(shutting_down=True) if context is None else context).shutdown()


def try_shutdown(*, context: Context | None = None) -> None:
    """End a context that lives."""
    if context is not None:
        context.try_shutdown()
        return
    context = get_default_context()
    context.try_shutdown()
    if context.handle is not None:
        get_default_context(shutting_down=True)


def get_rmw_implementation_identifier() -> str:
    """Return the name of the middleware: there is none but the simulation."""
    return rclpy_get_rmw_implementation_identifier()


def get_available_rmw_implementations() -> set[str]:
    """Return the names of all middlewares."""
    return {get_rmw_implementation_identifier()}


def timeout_sec_to_nsec(timeout_sec: Any) -> int:
    """Return a timeout in nanoseconds; -1 is for ever.

    Raises:
        ValueError: it is too long.
    """
    if timeout_sec is None or timeout_sec < 0:
        return -1
    return int(float(timeout_sec) * S_TO_NS)


__all__ = _defined(globals())
