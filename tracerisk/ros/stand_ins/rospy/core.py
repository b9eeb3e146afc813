"""Logging, and the life of the node: initialized, running, shut down."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from types import FrameType
from typing import Any

from tracerisk.ros.controller.frames import controller_frame
from tracerisk.ros.graph.failures import trouble_logged
from tracerisk.ros.imports.exported import defined as _defined
from tracerisk.ros.time.clock import EPOCH_NS

from ._node import NodeState, node
from .impl.validators import ParameterInvalid
from .names import (  # noqa: F401 - names of this module too
    SEP,
    get_caller_id,
    get_mappings,
    get_name,
    get_namespace,
    get_resolved_mappings,
    global_name,
    resolve_name,
    valid_name,
)
from .rostime import duration_ns

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16
_NAMES = {DEBUG: "DEBUG", INFO: "INFO", WARN: "WARN", ERROR: "ERROR", FATAL: "FATAL"}
ROSRPC = "rosrpc://"
_NODE_URI = "http://localhost:11312/"

# Logging


def _log(level: int, msg: Any, args: tuple[Any, ...], kwargs: dict[str, Any]) -> None:
    state = node()
    if level < state.log_level:
        return
    text = _formatted(msg, args)
    child = kwargs.get("logger_name")
    error = kwargs.get("exc_info")
    if error:
        shown = error if isinstance(error, BaseException) else sys.exc_info()[1]
        if shown is not None:
            text += "\n" + "".join(traceback.format_exception(shown)).rstrip()
    name = f" [{child}]" if child else ""
    print(f"[{_NAMES[level]}]{name} {text}", file=sys.stderr)  # noqa: T201 - this is its purpose
    _publish_to_rosout(state, level, text)
    if level >= WARN:
        trouble_logged(_NAMES[level], text)


def _formatted(msg: Any, args: tuple[Any, ...]) -> str:
    if not args:
        return str(msg)
    values = args[0] if len(args) == 1 and isinstance(args[0], dict) and args[0] else args
    try:
        return str(msg) % values
    except (TypeError, ValueError, KeyError):
        # A log line that is written wrongly stops no program; it is shown as it is.
        return f"{msg} {args}"


def _publish_to_rosout(state: NodeState, level: int, text: str) -> None:
    if not state.is_initialized or not state.graph.subscriptions("/rosout"):
        return
    from rosgraph_msgs.msg import Log

    from .msg import sent_copy
    from .rostime import Time

    if state.rosout is None:
        state.rosout = state.graph.advertise(
            "/rosout", Log._type, node=state.name, copy=lambda message: sent_copy(message, Log)
        )
    frame = controller_frame()
    log = Log(level=level, name=state.name, msg=text, topics=_topics_of(state))
    if frame is not None:
        log.file = Path(frame.f_code.co_filename).name
        log.line = frame.f_lineno
        owner = frame.f_locals.get("self")
        log.function = frame.f_code.co_name
        if owner is not None:
            log.function = f"{type(owner).__name__}.{log.function}"
    log.header.stamp = Time(0, EPOCH_NS + state.scheduler.now_ns)
    state.rosout.publish(log)


def _topics_of(state: NodeState) -> list[str]:
    """Return the topics that a node publishes or subscribes to, sorted."""
    graph = state.graph
    return [
        topic
        for topic in graph.topic_names()
        if any(publication.node == state.name for publication in graph.publications(topic))
        or any(subscription.node == state.name for subscription in graph.subscriptions(topic))
    ]


def _caller() -> tuple[str, int, int]:
    frame: FrameType | None = controller_frame()
    if frame is None:
        return ("", 0, 0)
    return (frame.f_code.co_filename, frame.f_lineno, frame.f_lasti)


def _is_first(caller: tuple[str, int, int]) -> bool:
    seen = node().logged_once
    if caller in seen:
        return False
    seen.add(caller)
    return True


def _is_due(caller: tuple[str, int, int], period: float) -> bool:
    state = node()
    now_ns = state.scheduler.now_ns
    last_ns = state.logged_at.get(caller)
    if last_ns is not None and now_ns - last_ns <= duration_ns(period):
        return False
    state.logged_at[caller] = now_ns
    return True


def _is_new(caller: tuple[str, int, int], text: str) -> bool:
    state = node()
    if state.logged_text.get(caller) == text:
        return False
    state.logged_text[caller] = text
    return True


def _plain(level: int) -> Callable[..., None]:
    def log(msg: Any, *args: Any, **kwargs: Any) -> None:
        _log(level, msg, args, kwargs)

    return _described(log, level, "Log a message; `args` are merged into it by `%`.")


def _throttle(level: int) -> Callable[..., None]:
    def log(period: float, msg: Any, *args: Any, **kwargs: Any) -> None:
        if _is_due(_caller(), period):
            _log(level, msg, args, kwargs)

    return _described(log, level, "Log at most once in `period` seconds from one line of code.")


def _throttle_identical(level: int) -> Callable[..., None]:
    def log(period: float, msg: Any, *args: Any, **kwargs: Any) -> None:
        caller = _caller()
        is_due = _is_due(caller, period)
        if _is_new(caller, str(msg)) or is_due:
            _log(level, msg, args, kwargs)

    return _described(log, level, "Log a new message at once, the same one every `period` seconds.")


def _once(level: int) -> Callable[..., None]:
    def log(msg: Any, *args: Any, **kwargs: Any) -> None:
        if _is_first(_caller()):
            _log(level, msg, args, kwargs)

    return _described(log, level, "Log only the first time that this line of code is reached.")


def _described(log: Callable[..., None], level: int, text: str) -> Callable[..., None]:
    log.__doc__ = f"{text}\n\nThe level is {_NAMES[level]}."
    return log


logdebug, loginfo, logwarn, logerr, logfatal = map(_plain, _NAMES)
logout = loginfo
logerror = logerr
(logdebug_throttle, loginfo_throttle, logwarn_throttle, logerr_throttle, logfatal_throttle) = map(
    _throttle, _NAMES
)
(
    logdebug_throttle_identical,
    loginfo_throttle_identical,
    logwarn_throttle_identical,
    logerr_throttle_identical,
    logfatal_throttle_identical,
) = map(_throttle_identical, _NAMES)
logdebug_once, loginfo_once, logwarn_once, logerr_once, logfatal_once = map(_once, _NAMES)


def rospydebug(msg: Any, *args: Any, **kwargs: Any) -> None:
    """Take a message of the library's own log, which goes to no terminal."""


rospyinfo = rospydebug
rospywarn = rospydebug


def rospyerr(msg: Any, *args: Any, **kwargs: Any) -> None:
    """Log an error of the library's own."""
    _log(ERROR, msg, args, kwargs)


# The node


def is_initialized() -> bool:
    """Return whether `init_node` has been called."""
    return node().is_initialized


def set_initialized(initialized: bool) -> None:
    """Set whether the node is initialized."""
    node().is_initialized = initialized


def is_shutdown() -> bool:
    """Return whether the node has shut down."""
    state = node()
    state.scheduler.touch()
    return state.is_shutdown


def is_shutdown_requested() -> bool:
    """Return whether a shutdown has begun."""
    state = node()
    state.scheduler.touch()
    return state.is_shutdown_requested


def get_node_uri() -> str | None:
    """Return the node's URI, or None before it is initialized."""
    state = node()
    return state.uri or (_NODE_URI if state.init_args else None)


def set_node_uri(uri: str) -> None:
    """Take another URI for the node's."""
    node().uri = uri


def get_ros_root(required: bool = False, env: Mapping[str, str] | None = None) -> str | None:
    """Return where the environment says that ROS is installed.

    Raises:
        ROSException: it does not say, and `required`.
    """
    from .exceptions import ROSException

    root = (os.environ if env is None else env).get("ROS_ROOT")
    if required and not root:
        raise ROSException("ROS_ROOT is not set")
    return root


def is_topic(param_name: str) -> Callable[[Any, str], str]:
    """Return a check of an argument that is the name of a topic, which it resolves."""

    def validator(param_value: Any, caller_id: str) -> str:
        name = valid_name(param_name)(param_value, caller_id)
        if param_value == SEP:
            raise ParameterInvalid(
                f"ERROR: parameter [{param_name}] cannot be the global namespace"
            )
        return name

    return validator


def parse_rosrpc_uri(uri: str) -> tuple[str, int]:
    """Return address and port of a service's URI.

    Raises:
        ParameterInvalid: it is none.
    """
    if not uri.startswith(ROSRPC):
        raise ParameterInvalid(f"Invalid protocol for ROS service URL: {uri}")
    address, _, port = uri.removeprefix(ROSRPC).partition("/")[0].partition(":")
    if not address or not port.isdigit():
        raise ParameterInvalid(f"ROS service URL is invalid: {uri}")
    return address, int(port)


def add_client_shutdown_hook(h: Callable[[], object]) -> None:
    """Call `h` when the node shuts down, before anything else."""
    _add_hook(h, node().client_hooks, ())


def add_preshutdown_hook(h: Callable[[str], object]) -> None:
    """Call `h` with the reason when the node shuts down, before `is_shutdown` turns true."""
    _add_hook(h, node().preshutdown_hooks, ("already shutdown",))


def add_shutdown_hook(h: Callable[[str], object]) -> None:
    """Call `h` with the reason when the node has shut down."""
    _add_hook(h, node().shutdown_hooks, ("already shutdown",))


def _add_hook(hook: Callable[..., object], hooks: list[Any], late: tuple[str, ...]) -> None:
    if not callable(hook):
        raise TypeError(
            f"shutdown hook [{hook}] must be a function or callable object: {type(hook)}"
        )
    if node().is_shutdown:
        hook(*late)
    else:
        hooks.append(hook)


def register_signals() -> None:
    """Shut the node down at SIGINT and SIGTERM that the program sends itself.

    Raises:
        ValueError: another thread than the main one calls this.
    """
    scheduler, signals = node().scheduler, node().scheduler.signals
    if scheduler.process is not None:
        return  # a companion gets none
    if scheduler.current is not None and not scheduler.current.is_main:
        raise ValueError("signal only works in main thread of the main interpreter")
    before: dict[int, Any] = {}

    def shut_down(number: int, frame: Any) -> None:
        signal_shutdown(f"signal-{number}")
        if callable(before[number]):
            # Python's own handler raises it, which is filtered out.
            with contextlib.suppress(KeyboardInterrupt):
                before[number](number, frame)

    for number in (signal.SIGTERM, signal.SIGINT):
        before[number] = signals.set_handler(number, shut_down)


def signal_shutdown(reason: str) -> None:
    """Shut the node down: run the hooks, wake everything that sleeps."""
    state = node()
    if state.is_shutdown or state.is_shutdown_requested:
        return
    state.is_shutdown_requested = True
    for hook in state.client_hooks:
        _call_hook(hook)
    for hook_with_reason in state.preshutdown_hooks:
        _call_hook(hook_with_reason, reason)
    state.is_shutdown = True
    for hook_with_reason in state.shutdown_hooks:
        _call_hook(hook_with_reason, reason)
    state.client_hooks, state.preshutdown_hooks, state.shutdown_hooks = [], [], []
    for publisher in list(state.publishers.values()):
        publisher.close()
    for subscriber in list(state.subscribers.values()):
        subscriber.close()


def _call_hook(hook: Callable[..., object], *args: str) -> None:
    try:
        hook(*args)
    except Exception:  # noqa: BLE001 - the controller's; rospy prints it and goes on
        traceback.print_exc()


__all__ = _defined(
    globals(),
    "ParameterInvalid",
    "get_caller_id",
    "get_mappings",
    "get_name",
    "get_namespace",
    "get_resolved_mappings",
    "global_name",
    "resolve_name",
    "valid_name",
)
