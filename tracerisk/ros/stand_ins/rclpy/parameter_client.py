"""Reading and setting the parameters of another node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)

from ._run import run
from .callback_groups import CallbackGroup
from .client import Client
from .node import Node
from .parameter import Parameter, parameter_dict_from_yaml_file
from .qos import QoSProfile, qos_profile_parameter_events, qos_profile_services_default
from .subscription import Subscription
from .task import Future

_POLL_NS = 250_000_000
Callback = Callable[[Any], Any] | None


class AsyncParameterClient:
    """Calls the parameter services of the node `remote_node_name`.

    Each call returns the future of the service's response; `callback` is called with it.
    """

    def __init__(
        self,
        node: Node,
        remote_node_name: str,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> None:
        self.remote_node_name = remote_node_name
        self.node = node

        def client(srv_type: Any, name: str) -> Client:
            return node.create_client(
                srv_type,
                f"{remote_node_name}/{name}",
                qos_profile=qos_profile,
                callback_group=callback_group,
            )

        self._get = client(GetParameters, "get_parameters")
        self._list = client(ListParameters, "list_parameters")
        self._set = client(SetParameters, "set_parameters")
        self._get_types = client(GetParameterTypes, "get_parameter_types")
        self._describe = client(DescribeParameters, "describe_parameters")
        self._set_atomically = client(SetParametersAtomically, "set_parameters_atomically")

    def services_are_ready(self) -> bool:
        """Return whether all services are served."""
        return all(client.service_is_ready() for client in self._clients)

    def wait_for_services(self, timeout_sec: float | None = None) -> bool:
        """Wait until all services are served, without a timeout [s] for ever; return whether so."""
        if timeout_sec is None:
            return all(client.wait_for_service() for client in self._clients)
        scheduler = run().scheduler
        end_ns = scheduler.now_ns + round(timeout_sec * 1e9)
        while not self.services_are_ready() and scheduler.now_ns < end_ns:
            scheduler.sleep(_POLL_NS)
        return self.services_are_ready()

    def list_parameters(
        self,
        prefixes: list[str] | None = None,
        depth: int | None = None,
        callback: Callback = None,
    ) -> Future:
        """List the names below prefixes, down to a depth; without them, all."""
        request = ListParameters.Request(prefixes=prefixes or [], depth=depth or 0)
        return _called(self._list, request, callback)

    def get_parameters(self, names: list[str], callback: Callback = None) -> Future:
        """Read parameters."""
        return _called(self._get, GetParameters.Request(names=names), callback)

    def set_parameters(self, parameters: Sequence[Any], callback: Callback = None) -> Future:
        """Set parameters one by one: `Parameter`s or their messages."""
        request = SetParameters.Request(parameters=_messages(parameters))
        return _called(self._set, request, callback)

    def describe_parameters(self, names: list[str], callback: Callback = None) -> Future:
        """Read the descriptors of parameters."""
        return _called(self._describe, DescribeParameters.Request(names=names), callback)

    def get_parameter_types(self, names: list[str], callback: Callback = None) -> Future:
        """Read the types of parameters: the numbers of `Parameter.Type`."""
        return _called(self._get_types, GetParameterTypes.Request(names=names), callback)

    def set_parameters_atomically(
        self, parameters: Sequence[Any], callback: Callback = None
    ) -> Future:
        """Set all parameters or none."""
        request = SetParametersAtomically.Request(parameters=_messages(parameters))
        return _called(self._set_atomically, request, callback)

    def delete_parameters(self, names: list[str], callback: Callback = None) -> Future:
        """Unset parameters; only those of dynamic type can be."""
        return self.set_parameters([Parameter(name) for name in names], callback)

    def load_parameter_file(
        self, parameter_file: str, use_wildcard: bool = False, callback: Callback = None
    ) -> Future:
        """Set the parameters of a YAML file one by one."""
        parameter_dict = parameter_dict_from_yaml_file(parameter_file, use_wildcard)
        return self.set_parameters(list(parameter_dict.values()), callback)

    def load_parameter_file_atomically(
        self, parameter_file: str, use_wildcard: bool = False, callback: Callback = None
    ) -> Future:
        """Set all parameters of a YAML file or none."""
        parameter_dict = parameter_dict_from_yaml_file(parameter_file, use_wildcard)
        return self.set_parameters_atomically(list(parameter_dict.values()), callback)

    def on_parameter_event(
        self,
        callback: Callable[..., Any],
        qos_profile: QoSProfile = qos_profile_parameter_events,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: Any = None,
        qos_overriding_options: Any = None,
        raw: bool = False,
    ) -> Subscription:
        """Subscribe to the changes of every node's parameters."""
        return self.node.create_subscription(
            ParameterEvent,
            "/parameter_events",
            callback,
            qos_profile,
            callback_group=callback_group,
            event_callbacks=event_callbacks,
            qos_overriding_options=qos_overriding_options,
            raw=raw,
        )

    @property
    def _clients(self) -> tuple[Client, ...]:
        return (
            self._list,
            self._set,
            self._get,
            self._get_types,
            self._describe,
            self._set_atomically,
        )


def _called(client: Client, request: Any, callback: Callback) -> Future:
    future = client.call_async(request)
    if callback is not None:
        future.add_done_callback(callback)
    return future


def _messages(parameters: Sequence[Any]) -> list[Any]:
    return [
        parameter.to_parameter_msg() if isinstance(parameter, Parameter) else parameter
        for parameter in parameters
    ]
