"""Callbacks for the changes of parameters, of this node and of others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import ParameterEvent

from .callback_groups import CallbackGroup
from .node import Node
from .qos import QoSProfile, qos_profile_parameter_events


@dataclass(eq=False)
class ParameterCallbackHandle:
    """The handle by which a callback for one parameter is removed."""

    parameter_name: str
    """The name of the parameter."""
    node_name: str
    """The full name of the node that has the parameter."""
    callback: Callable[[Any], None]
    """The function for each change."""


@dataclass(eq=False)
class ParameterEventCallbackHandle:
    """The handle by which a callback for all changes is removed."""

    callback: Callable[[Any], None]
    """The function for each event."""


class ParameterEventHandler:
    """Listens to the changes of parameters; of several callbacks the latest comes first."""

    def __init__(
        self,
        node: Node,
        qos_profile: QoSProfile = qos_profile_parameter_events,
        callback_group: CallbackGroup | None = None,
        event_callbacks: Any = None,
        qos_overriding_options: Any = None,
        raw: bool = False,
    ) -> None:
        self.node = node
        self.qos_profile = qos_profile
        self._callbacks = _Callbacks()
        self.parameter_event_subscription = node.create_subscription(
            ParameterEvent,
            "/parameter_events",
            self._callbacks.event_callback,
            qos_profile,
            callback_group=callback_group,
            event_callbacks=event_callbacks,
            qos_overriding_options=qos_overriding_options,
            raw=raw,
        )

    def destroy(self) -> None:
        """Listen no longer."""
        self.node.destroy_subscription(self.parameter_event_subscription)

    @staticmethod
    def get_parameter_from_event(event: Any, parameter_name: str, node_name: str) -> Any:
        """Return the message of a parameter that an event of a node is about, else None."""
        if event.node != node_name:
            return None
        parameters = ParameterEventHandler.get_parameters_from_event(event)
        return next((item for item in parameters if item.name == parameter_name), None)

    @staticmethod
    def get_parameters_from_event(event: Any) -> Iterator[Any]:
        """Yield the messages of the parameters that are new or have changed."""
        yield from event.new_parameters
        yield from event.changed_parameters

    def add_parameter_callback(
        self, parameter_name: str, node_name: str, callback: Callable[[Any], None]
    ) -> ParameterCallbackHandle:
        """Call `callback` with the message of a parameter of a node whenever it changes."""
        handle = ParameterCallbackHandle(parameter_name, self._resolve_path(node_name), callback)
        key = handle.parameter_name, handle.node_name
        self._callbacks.parameter_callbacks.setdefault(key, []).insert(0, handle)
        return handle

    def remove_parameter_callback(self, handle: ParameterCallbackHandle) -> None:
        """Undo `add_parameter_callback`.

        Raises:
            RuntimeError: it is not there.
        """
        key = handle.parameter_name, handle.node_name
        kept = self._callbacks.parameter_callbacks.get(key, [])
        _remove(kept, handle)
        if not kept:
            del self._callbacks.parameter_callbacks[key]

    def add_parameter_event_callback(
        self, callback: Callable[[Any], None]
    ) -> ParameterEventCallbackHandle:
        """Call `callback` with every event."""
        handle = ParameterEventCallbackHandle(callback)
        self._callbacks.event_callbacks.insert(0, handle)
        return handle

    def remove_parameter_event_callback(self, handle: ParameterEventCallbackHandle) -> None:
        """Undo `add_parameter_event_callback`.

        Raises:
            RuntimeError: it is not there.
        """
        _remove(self._callbacks.event_callbacks, handle)

    def _resolve_path(self, node_path: str = "") -> str:
        if not node_path:
            return self.node.get_fully_qualified_name()
        if node_path.startswith("/"):
            return node_path
        return f"{self.node.get_namespace().rstrip('/')}/{node_path}"


class _Callbacks:
    """What is called on changes of parameters, by their names and nodes, and on all of them."""

    def __init__(self) -> None:
        self.parameter_callbacks: dict[tuple[str, str], list[ParameterCallbackHandle]] = {}
        self.event_callbacks: list[ParameterEventCallbackHandle] = []

    def event_callback(self, event: Any) -> None:
        """Call whoever wants to know of an event."""
        for (name, node), handles in list(self.parameter_callbacks.items()):
            parameter = ParameterEventHandler.get_parameter_from_event(event, name, node)
            if parameter is not None:
                for handle in list(handles):
                    handle.callback(parameter)
        for callback in list(self.event_callbacks):
            callback.callback(event)


def _remove(kept: list[Any], handle: Any) -> None:
    if handle not in kept:
        raise RuntimeError("Callback doesn't exist")
    kept.remove(handle)
