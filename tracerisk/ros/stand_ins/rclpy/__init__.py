"""Stand-in for rclpy, the Python client library of ROS 2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tracerisk.ros.controller.thread import spinning
from tracerisk.ros.imports.exported import defined as _defined

from ._run import run as _state
from .context import Context
from .parameter import Parameter  # noqa: F401 - names of this module too
from .signals import SignalHandlerOptions, install_signal_handlers, uninstall_signal_handlers
from .task import Future
from .utilities import get_default_context, get_rmw_implementation_identifier, ok, try_shutdown  # noqa: F401 - names of this module too
from .utilities import shutdown as _shutdown


def init(
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
) -> _Begun | None:
    """Begin; `args` is a command line, by default the program's own.

    After Jazzy, what is returned ends with its `with` block (rclpy 7.4, rclpy/__init__.py).

    Raises:
        RuntimeError: it has begun already, or the command line is malformed.
    """
    chosen = get_default_context() if context is None else context
    if signal_handler_options is None:
        is_default = chosen is get_default_context()
        signal_handler_options = SignalHandlerOptions.ALL if is_default else SignalHandlerOptions.NO
    chosen.init(args, domain_id=domain_id)
    install_signal_handlers(signal_handler_options)
    return _Begun(chosen) if _state().runtime.distro.follows_jazzy else None


class _Begun:
    """A context that has begun, for a `with` block."""

    def __init__(self, context: Context) -> None:
        self.context = context

    def __enter__(self) -> _Begun:
        return self

    def __exit__(self, *error: object) -> None:
        # A default context that has ended is replaced only where none is named.
        try_shutdown(context=None if self.context is get_default_context() else self.context)


def get_global_executor() -> Any:
    """Return the executor that is used where none is given."""
    state = _state()
    if state.global_executor is None:
        from .executors import SingleThreadedExecutor

        made = state.global_executor = SingleThreadedExecutor()

        def forget() -> None:
            made.shutdown()
            state.global_executor = None

        get_default_context().on_shutdown(forget)
    return state.global_executor


def shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:
    """End: everything that spins returns.

    Raises:
        RuntimeError: it has not begun, or has ended already.
    """
    _shutdown(context=context)
    if uninstall_handlers or (uninstall_handlers is None and context is None):
        uninstall_signal_handlers()


def create_node(node_name: str, **kwargs: Any) -> Any:
    """Make a node; the keywords are those of `Node`."""
    from .node import Node

    return Node(node_name, **kwargs)


def spin_once(node: Any, *, executor: Any = None, timeout_sec: float | None = None) -> None:
    """Run one callback of a node, waiting for it `timeout_sec` seconds, or for ever.

    The node leaves the executor that it was in, for good; in Humble the one that is given too.
    """
    chosen = get_global_executor() if executor is None else executor
    leaves = not _state().runtime.distro.value("spin-once-leaves-node-where-it-was")
    try:
        leaves = chosen.add_node(node) or leaves
        chosen.spin_once(timeout_sec=timeout_sec)
    finally:
        if leaves:
            chosen.remove_node(node)


def spin(node: Any, executor: Any = None) -> None:
    """Run the callbacks of a node until the context is shut down."""
    chosen = get_global_executor() if executor is None else executor
    try:
        chosen.add_node(node)
        scheduler = _state().scheduler
        with spinning(scheduler.current, scheduler.now_ns):
            while chosen.context.is_valid:
                chosen.spin_once()
    finally:
        chosen.remove_node(node)


def spin_until_future_complete(
    node: Any, future: Future, executor: Any = None, timeout_sec: float | None = None
) -> None:
    """Run the callbacks of a node until a future is complete, or for `timeout_sec` seconds.

    Within a callback of the node's this hangs where the future needs a callback of the same
    exclusive group; a run in which nothing else can happen ends and says so.
    """
    chosen = get_global_executor() if executor is None else executor
    added = False
    try:
        added = chosen.add_node(node)
        chosen.spin_until_future_complete(future, timeout_sec)
    finally:
        if added:
            chosen.remove_node(node)


__all__ = _defined(
    globals(),
    "Context",
    "Future",
    "Parameter",
    "SignalHandlerOptions",
    "get_default_context",
    "get_rmw_implementation_identifier",
    "ok",
    "try_shutdown",
)
