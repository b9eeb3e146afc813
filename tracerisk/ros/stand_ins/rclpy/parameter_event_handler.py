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
    """A callback for one parameter, to be removed by."""

    parameter_name: str
    node_name: str
    callback: Callable[[Any], None]


@dataclass(eq=False)
class ParameterEventCallbackHandle:
    """A callback for all changes, to be removed by."""

    callback: Callable[[Any], None]


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
        self._for_one: list[ParameterCallbackHandle] = []
        self._for_all: list[ParameterEventCallbackHandle] = []
        self.parameter_event_subscription = node.create_subscription(
            ParameterEvent,
            "/parameter_events",
            self._on_event,
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
        found = ParameterEventHandler.get_parameters_from_event(event)
        return next((each for each in found if each.name == parameter_name), None)

    @staticmethod
    def get_parameters_from_event(event: Any) -> Iterator[Any]:
        """Yield the messages of the parameters that are new or have changed."""
        yield from event.new_parameters
        yield from event.changed_parameters

    def add_parameter_callback(
        self, parameter_name: str, node_name: str, callback: Callable[[Any], None]
    ) -> ParameterCallbackHandle:
        """Call `callback` with the message of a parameter of a node whenever it changes."""
        handle = ParameterCallbackHandle(parameter_name, self._full_name(node_name), callback)
        self._for_one.insert(0, handle)
        return handle

    def remove_parameter_callback(self, handle: ParameterCallbackHandle) -> None:
        """Undo `add_parameter_callback`.

        Raises:
            RuntimeError: it is not there.
        """
        _remove(self._for_one, handle)

    def add_parameter_event_callback(
        self, callback: Callable[[Any], None]
    ) -> ParameterEventCallbackHandle:
        """Call `callback` with every event."""
        handle = ParameterEventCallbackHandle(callback)
        self._for_all.insert(0, handle)
        return handle

    def remove_parameter_event_callback(self, handle: ParameterEventCallbackHandle) -> None:
        """Undo `add_parameter_event_callback`.

        Raises:
            RuntimeError: it is not there.
        """
        _remove(self._for_all, handle)

    def _on_event(self, event: Any) -> None:
        for one in list(self._for_one):
            parameter = self.get_parameter_from_event(event, one.parameter_name, one.node_name)
            if parameter is not None:
                one.callback(parameter)
        for each in list(self._for_all):
            each.callback(event)

    def _full_name(self, node_name: str) -> str:
        if not node_name:
            return self.node.get_fully_qualified_name()
        if node_name.startswith("/"):
            return node_name
        return f"{self.node.get_namespace().rstrip('/')}/{node_name}"


def _remove(kept: list[Any], handle: Any) -> None:
    if handle not in kept:
        raise RuntimeError("Callback doesn't exist")
    kept.remove(handle)
