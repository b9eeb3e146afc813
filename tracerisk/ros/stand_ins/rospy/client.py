"""The node: its start, its parameters, and waiting for messages."""

from __future__ import annotations

import warnings
from typing import Any

from tracerisk.ros.controller.needs import Need
from tracerisk.ros.graph import graph_names
from tracerisk.ros.graph.parameter_files import private_of
from tracerisk.ros.graph.yaml_text import load_yaml
from tracerisk.ros.imports.exported import defined as _defined
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.time.rostime import Duration

from . import names
from ._node import node
from .core import (  # noqa: F401 - names of this module too
    DEBUG,
    ERROR,
    FATAL,
    INFO,
    WARN,
    add_client_shutdown_hook,
    register_signals,
    signal_shutdown,
)
from .exceptions import ROSException, ROSInitException, ROSInterruptException
from .msproxy import MasterProxy
from .rostime import duration_ns
from .topics import Subscriber

TIMEOUT_READY = 15.0
_SIMULATED = "/use_sim_time"
_UNSPECIFIED = object()


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return a command line, by default the program's own, without what is meant for ROS."""
    given = node().runtime.argv if argv is None else argv
    return [argument for argument in given if not graph_names.is_legal_remap(argument)]


def load_command_line_node_params(argv: list[str]) -> dict[str, Any]:
    """Return the private parameters of a command line: `_name:=value`, the value as YAML.

    Raises:
        ROSInitException: a value is not YAML.
    """
    parameters = graph_names.load_parameters(argv)
    if not parameters:
        return {}
    from ruamel.yaml.error import YAMLError

    try:
        return {name: load_yaml(text) for name, text in parameters.items()}
    except YAMLError as error:
        raise ROSInitException(f"invalid command-line parameters: {error}") from error


def init_node(
    name: str,
    argv: list[str] | None = None,
    anonymous: bool = False,
    log_level: int | None = None,
    disable_rostime: bool = False,
    disable_rosout: bool = False,
    disable_signals: bool = False,
    xmlrpc_port: int = 0,
    tcpros_port: int = 0,
) -> None:
    """Give the node its name and start it; a second call must have the same arguments.

    Raises:
        ValueError: the name is empty or holds a namespace.
        ROSException: a second call has other arguments.
        ROSInitException: the node has shut down, or a parameter on the command line is not YAML.
    """
    state = node()
    if argv is None:
        argv = list(state.runtime.argv)
    else:
        names.reload_mappings(argv)
    if not name:
        raise ValueError("name must not be empty")
    if names.SEP in name:
        raise ValueError("namespaces are not allowed in node names")
    given = (name, argv, anonymous, log_level, disable_rostime, disable_signals)
    if state.init_args is not None:
        if state.init_args != given:
            raise ROSException(
                "rospy.init_node() has already been called with different arguments: "
                f"{state.init_args}"
            )
        return
    state.init_args = given
    if "__name" in state.mappings:
        name, anonymous = state.mappings["__name"], False
    if anonymous:
        # The real one takes the process and the time; no two runs of the same must differ.
        name = f"{name}_1_{(EPOCH_NS + state.scheduler.now_ns) // 1_000_000}"
    if not graph_names.is_legal_base_name(name):
        warnings.warn(
            f"'{name}' is not a legal ROS base name. This may cause problems with other ROS tools.",
            stacklevel=2,
        )
    if not disable_signals:
        register_signals()
    state.set_name(graph_names.resolve(name, state.name))
    if state.is_shutdown:
        raise ROSInitException("init_node interrupted before it could complete")
    for key, value in private_of(state.runtime.parameters):
        own = graph_names.resolve(graph_names.PRIVATE + key, state.name)
        state.runtime.graph.parameters.set_default(own, value)
    for key, value in load_command_line_node_params(argv).items():
        set_param(graph_names.PRIVATE + key, value)
    if log_level is not None:
        state.log_level = log_level
    state.is_initialized = True
    state.is_time_initialized = True
    parameters = state.graph.parameters
    state.has_simulated_time = bool(parameters.has(_SIMULATED) and parameters.get(_SIMULATED))


def spin() -> None:
    """Wait until the node shuts down.

    Raises:
        ROSInitException: the node is not initialized.
    """
    state = node()
    if not state.is_initialized:
        raise ROSInitException("client code must call rospy.init_node() first")
    try:
        state.wait(lambda: False, None, "callbacks", "idle")
    except KeyboardInterrupt:
        signal_shutdown("keyboard interrupt")


def on_shutdown(h: Any) -> None:
    """Call `h` when the node shuts down."""
    add_client_shutdown_hook(h)


def get_master(env: Any = None) -> MasterProxy:
    """Return the master."""
    return MasterProxy()


def get_published_topics(namespace: str = "/") -> list[list[str]]:
    """Return [name, type] of each topic that somebody publishes."""
    topics: list[list[str]] = get_master().getPublishedTopics(namespace)[2]
    return topics


def wait_for_message(topic: str, topic_type: Any, timeout: float | Duration | None = None) -> Any:
    """Wait for one message of a topic and return it.

    Raises:
        ROSException: none came within `timeout` (seconds or a Duration).
        ROSInterruptException: the node shuts down first.
    """
    state = node()
    received: list[Any] = []
    subscriber = Subscriber(topic, topic_type, received.append)
    name = subscriber.resolved_name
    try:
        arrived = state.wait(
            lambda: bool(received),
            None if timeout is None else duration_ns(timeout),
            f"a message on {name} ({topic_type._type})",
            "unmet",
            Need("topic", name, topic_type._type),
        )
    finally:
        subscriber.unregister()
    if state.is_shutdown:
        raise ROSInterruptException("rospy shutdown")
    if not arrived:
        raise ROSException(f"timeout exceeded while waiting for message on topic {topic}")
    return received[0]


def get_param(param_name: str, default: Any = _UNSPECIFIED) -> Any:
    """Return a parameter, or `default` where it is not set.

    Raises:
        KeyError: it is not set and no default is given.
    """
    try:
        value = get_master()[param_name]
        scheduler, need = node().scheduler, Need("parameter", names.resolve_name(param_name))
        scheduler.needs.take(need, value, scheduler.now_ns)
        return value
    except KeyError:
        if default is _UNSPECIFIED:
            value = node().graph.parameters.beyond(names.resolve_name(param_name))
            if value is None:
                raise
            node().scheduler.needs.meet(Need("parameter", names.resolve_name(param_name)))
            return value
        # It can do without.
        scheduler, need = node().scheduler, Need("parameter", names.resolve_name(param_name))
        scheduler.needs.meet(need)
        scheduler.needs.take_default(need, default, scheduler.now_ns)
        return default


def get_param_cached(param_name: str, default: Any = _UNSPECIFIED) -> Any:
    """Return a parameter; see `get_param`."""
    return get_param(param_name, default)


def get_param_names() -> list[str]:
    """Return the names of all parameters."""
    parameters = node().graph.parameters
    parameters.ask("/")
    return sorted({*parameters.names(), *parameters.offered_names()})


def set_param(param_name: str, param_value: Any) -> None:
    """Set a parameter; a dictionary replaces the whole namespace."""
    names._warn_unless_legal(param_name, 2)
    get_master()[param_name] = param_value


def search_param(param_name: str) -> str | None:
    """Return the full name of a parameter looked for from the node's names up to the root."""
    return get_master().search_param(param_name)


def delete_param(param_name: str) -> None:
    """Remove a parameter.

    Raises:
        KeyError: it is not set.
    """
    del get_master()[param_name]


def has_param(param_name: str) -> bool:
    """Return whether a parameter is set."""
    return param_name in get_master()


__all__ = _defined(globals(), "DEBUG", "ERROR", "FATAL", "INFO", "WARN")
