"""Nodes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from rcl_interfaces.msg import ParameterEvent

from tracerisk.ros.scenario_parameters import overrides_of

from ._logger import RcutilsLogger
from ._node_parameters import NodeParameters
from ._run import run
from .callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from .client import Client
from .clock import Clock, ROSClock
from .constants import S_TO_NS
from .context import Context
from .exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    NotInitializedException,
    NoTypeSupportImportedException,
)
from .guard_condition import GuardCondition
from .parameter import Parameter
from .publisher import Publisher
from .qos import (
    QoSProfile,
    qos_profile_parameter_events,
    qos_profile_services_default,
)
from .service import Service
from .subscription import Subscription
from .timer import Rate, Timer

__all__ = ["Node", "NodeNameNonExistentError"]

_NODE_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_NAME = re.compile(r"~?(/?[A-Za-z_{}]\w*[\w{}]*)?(/[A-Za-z_{][\w{}]*)*", re.ASCII)


class NodeNameNonExistentError(RuntimeError):
    """No node of the name exists."""


class Node(NodeParameters):
    """A node: publishers, subscriptions, services, timers, parameters, under one name.

    Raises:
        NotInitializedException: `rclpy.init()` has not been called.
        InvalidNodeNameException: the name is not one that ROS takes.
        InvalidNamespaceException: the namespace is not.
    """

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: Sequence[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        rosout_qos_profile: Any = None,
        start_parameter_services: bool = True,
        parameter_overrides: Sequence[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
        enable_logger_service: bool = False,
    ) -> None:
        from ._arguments import FLAG, Arguments, parse_arguments

        state = run()
        self._context = state.default_context if context is None else context
        if not self._context.is_valid:
            raise NotInitializedException("cannot create node")
        own = parse_arguments([FLAG, *cli_args]) if cli_args else Arguments()
        everyones = self._context.arguments if use_global_arguments else Arguments()
        given = Arguments(parameters=list(overrides_of(state.runtime.parameters)))
        self._sources = (own, everyones, given)
        self._given_name = node_name
        if not _NODE_NAME.fullmatch(node_name):
            raise InvalidNodeNameException(
                node_name,
                "node name must not be empty"
                if not node_name
                else "node name must not contain characters other than alphanumerics or '_', "
                "and must not start with a number",
                0,
            )
        self._name = self._renamed("__node", "__name") or node_name
        self._namespace = _namespace(self._renamed("__ns") or namespace or "")
        self._parameters = {}
        self._descriptors = {}
        self._pre_set_callbacks = []
        self._on_set_callbacks = []
        self._post_set_callbacks = []
        self._allow_undeclared_parameters = allow_undeclared_parameters
        self._parameter_overrides = self._overrides(parameter_overrides or ())
        self._publishers: list[Publisher] = []
        self._subscriptions: list[Subscription] = []
        self._clients: list[Client] = []
        self._services: list[Service] = []
        self._timers: list[Timer] = []
        self._guards: list[GuardCondition] = []
        self._waitables: list[Any] = []
        self._rates: list[Rate] = []
        self._executor: Any = None
        self._default_callback_group = MutuallyExclusiveCallbackGroup()
        self._rate_group = ReentrantCallbackGroup()
        self._clock = ROSClock()
        self._logger = RcutilsLogger(self.get_fully_qualified_name().strip("/").replace("/", "."))
        self._event_publisher = self.create_publisher(
            ParameterEvent, "/parameter_events", qos_profile_parameter_events
        )
        state.nodes.append(self)
        if not self._parameter_overrides.get("use_sim_time"):
            self.declare_parameter("use_sim_time", False)
        else:
            self.declare_parameter("use_sim_time", Parameter.Type.BOOL)
        if automatically_declare_parameters_from_overrides:
            rest = [name for name in self._parameter_overrides if name not in self._parameters]
            self.declare_parameters(
                "", [(name, self._parameter_overrides[name].value) for name in rest]
            )

    def _renamed(self, *keys: str) -> str | None:
        for source in self._sources:
            for key in keys:
                found = source.remapped(self._given_name, key)
                if found is not None:
                    return found
        return None

    def _overrides(self, given: Sequence[Parameter]) -> dict[str, Parameter]:
        full_name = self.get_fully_qualified_name()
        found: dict[str, Parameter] = {}
        for source in reversed(self._sources):
            values = source.overrides(self._name, full_name)
            found |= {name: Parameter(name, value=_plain(v)) for name, v in values.items()}
        return found | {parameter.name: parameter for parameter in given}

    # What it has

    def _entities(self) -> Iterator[Any]:
        """Return what an executor asks for work, in the order of rclpy."""
        yield from tuple(self._timers)
        yield from tuple(self._subscriptions)
        yield from tuple(self._guards)
        yield from tuple(self._clients)
        yield from tuple(self._services)

    @property
    def publishers(self) -> Iterator[Publisher]:
        """The publishers."""
        yield from self._publishers

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """The subscriptions."""
        yield from self._subscriptions

    @property
    def clients(self) -> Iterator[Client]:
        """The clients of services."""
        yield from self._clients

    @property
    def services(self) -> Iterator[Service]:
        """The services."""
        yield from self._services

    @property
    def timers(self) -> Iterator[Timer]:
        """The timers."""
        yield from self._timers

    @property
    def guards(self) -> Iterator[GuardCondition]:
        """The guard conditions."""
        yield from self._guards

    @property
    def waitables(self) -> Iterator[Any]:
        """The clients and servers of actions."""
        yield from self._waitables

    @property
    def executor(self) -> Any:
        """The executor that runs the callbacks, if any."""
        return self._executor

    @executor.setter
    def executor(self, new_executor: Any) -> None:
        current = self._executor
        if current is not None and current is not new_executor:
            current.remove_node(self)
        self._executor = new_executor
        if new_executor is not None and self not in new_executor._nodes:
            new_executor.add_node(self)

    @property
    def context(self) -> Context:
        """The context that the node lives in."""
        return self._context

    @property
    def default_callback_group(self) -> CallbackGroup:
        """The group of what is given none: one callback at a time."""
        return self._default_callback_group

    def get_name(self) -> str:
        """Return the name."""
        return self._name

    def get_namespace(self) -> str:
        """Return the namespace: `/`, or with no slash at its end."""
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """Return namespace and name."""
        return f"{self._namespace.rstrip('/')}/{self._name}"

    def get_clock(self) -> Clock:
        """Return the clock."""
        return self._clock

    def get_logger(self) -> RcutilsLogger:
        """Return the logger."""
        return self._logger

    def add_waitable(self, waitable: Any) -> None:
        """Ask `waitable` for work too."""
        self._waitables.append(waitable)

    def remove_waitable(self, waitable: Any) -> None:
        """Ask `waitable` for work no longer."""
        if waitable in self._waitables:
            self._waitables.remove(waitable)

    # Names

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the full name of a topic, remapped unless `only_expand`.

        Raises:
            InvalidTopicNameException: it is not one that ROS takes.
        """
        return self._resolved(topic, InvalidTopicNameException, remaps=not only_expand)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return the full name of a service, remapped unless `only_expand`.

        Raises:
            InvalidServiceNameException: it is not one that ROS takes.
        """
        return self._resolved(service, InvalidServiceNameException, remaps=not only_expand)

    def _resolved(self, name: str, error: Any, *, remaps: bool = True) -> str:
        if not isinstance(name, str):
            raise TypeError(f"name must be a str, not {type(name).__name__}")
        if not name or not _NAME.fullmatch(name) or name == "/":
            told = (
                "name must not be empty"
                if not name
                else (
                    "name must hold nothing but alphanumerics, '_', '/', '~' and '{}', no part may "
                    "start with a number and it must not end with '/'"
                )
            )
            raise error(name, told, 0)
        full = self._expanded(name)
        if not remaps:
            return full
        for source in self._sources:
            for whom, old, new in source.remaps:
                if whom not in (None, self._name) or old.startswith("__"):
                    continue
                if self._expanded(old) == full:
                    return self._expanded(new)
        return full

    def _expanded(self, name: str) -> str:
        text = name.replace("{node}", self._name)
        for key in ("{ns}", "{namespace}"):
            text = text.replace(key, self._namespace)
        if text.startswith("~"):
            return f"{self.get_fully_qualified_name()}/{text[1:].lstrip('/')}".rstrip("/")
        if text.startswith("/"):
            return re.sub("/+", "/", text)
        return f"{self._namespace.rstrip('/')}/{text}"

    # Making

    def create_publisher(
        self,
        msg_type: Any,
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: Any = None,
        qos_overriding_options: Any = None,
        publisher_class: type[Publisher] = Publisher,
    ) -> Publisher:
        """Make a publisher; an integer for the profile is its depth.

        Raises:
            TypeError: the profile is neither.
            ValueError: the depth is negative.
            NoTypeSupportImportedException: `msg_type` is no message class.
        """
        _check_type(msg_type, "get_fields_and_field_types")
        made = publisher_class(
            self,
            msg_type,
            self.resolve_topic_name(topic),
            _profile(qos_profile),
            event_callbacks,
            callback_group or self._default_callback_group,
        )
        self._publishers.append(made)
        return made

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: Any = None,
        qos_overriding_options: Any = None,
        raw: bool = False,
        content_filter_options: Any = None,
    ) -> Subscription:
        """Make a subscription; see `create_publisher`."""
        _check_type(msg_type, "get_fields_and_field_types")
        made = Subscription(
            self,
            msg_type,
            self.resolve_topic_name(topic),
            callback,
            callback_group or self._default_callback_group,
            _profile(qos_profile),
            raw,
            event_callbacks,
        )
        self._subscriptions.append(made)
        return made

    def create_client(
        self,
        srv_type: Any,
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Client:
        """Make a client of a service.

        Raises:
            NoTypeSupportImportedException: `srv_type` is no service class.
        """
        _check_type(srv_type, "Request")
        made = Client(
            self,
            srv_type,
            self.resolve_service_name(srv_name),
            qos_profile,
            callback_group or self._default_callback_group,
        )
        self._clients.append(made)
        return made

    def create_service(
        self,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Service:
        """Make a service: `callback` takes request and response, and returns the response.

        Raises:
            NoTypeSupportImportedException: `srv_type` is no service class.
        """
        _check_type(srv_type, "Request")
        made = Service(
            self,
            srv_type,
            self.resolve_service_name(srv_name),
            callback,
            callback_group or self._default_callback_group,
            qos_profile,
        )
        self._services.append(made)
        return made

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[..., Any] | None,
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Make a timer of a period in seconds."""
        made = Timer(
            self,
            callback,
            callback_group or self._default_callback_group,
            int(float(timer_period_sec) * S_TO_NS),
            self._clock if clock is None else clock,
            context=self._context,
            autostart=autostart,
        )
        self._timers.append(made)
        return made

    def create_guard_condition(
        self, callback: Callable[..., Any] | None, callback_group: CallbackGroup | None = None
    ) -> GuardCondition:
        """Make a guard condition."""
        made = GuardCondition(self, callback, callback_group or self._default_callback_group)
        self._guards.append(made)
        return made

    def create_rate(self, frequency: float, clock: Clock | None = None) -> Rate:
        """Make a rate of a frequency in hertz.

        Raises:
            ValueError: the frequency is not positive.
        """
        if frequency <= 0:
            raise ValueError("frequency must be > 0")
        timer = self.create_timer(1.0 / frequency, None, self._rate_group, clock)
        made = Rate(timer, context=self._context)
        self._rates.append(made)
        return made

    # Destroying

    def destroy_publisher(self, publisher: Publisher) -> bool:
        """Destroy a publisher; False where it is none of the node's."""
        return _destroy(self._publishers, publisher)

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Destroy a subscription; False where it is none of the node's."""
        return _destroy(self._subscriptions, subscription)

    def destroy_client(self, client: Client) -> bool:
        """Destroy a client; False where it is none of the node's."""
        return _destroy(self._clients, client)

    def destroy_service(self, service: Service) -> bool:
        """Destroy a service; False where it is none of the node's."""
        return _destroy(self._services, service)

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer; False where it is none of the node's."""
        return _destroy(self._timers, timer)

    def destroy_guard_condition(self, guard: GuardCondition) -> bool:
        """Destroy a guard condition; False where it is none of the node's."""
        return _destroy(self._guards, guard)

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate; False where it is none of the node's."""
        if rate not in self._rates:
            return False
        self.destroy_timer(rate._timer)
        return _destroy(self._rates, rate)

    def destroy_node(self) -> None:
        """Destroy all that the node has, and leave the executor."""
        if self._executor is not None:
            self._executor.remove_node(self)
            self._executor = None
        for kept in (
            self._rates,
            self._publishers,
            self._subscriptions,
            self._clients,
            self._services,
            self._timers,
            self._guards,
            self._waitables,
        ):
            for each in list(kept):
                each.destroy()
            kept.clear()
        nodes = run().nodes
        if self in nodes:
            nodes.remove(self)

    # The graph

    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        """Return each topic with its types: `std_msgs/msg/String`."""
        graph = run().graph
        found = []
        run().scheduler.touch()
        for name in graph.topic_names():
            ends: list[Any] = [*graph.publications(name), *graph.subscriptions(name)]
            if ends:
                found.append((name, sorted({_full_type(end.type_name, "msg") for end in ends})))
        return found

    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return each service with its types: `std_srvs/srv/Trigger`."""
        run().scheduler.touch()
        return [
            (server.name, [_full_type(server.type_name, "srv")])
            for server in run().graph.services()
        ]

    def get_node_names(self) -> list[str]:
        """Return the names of the controller's nodes."""
        return [node.get_name() for node in run().nodes]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return names and namespaces of the controller's nodes."""
        return [(node.get_name(), node.get_namespace()) for node in run().nodes]

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publish on a topic."""
        run().scheduler.touch()
        return len(run().graph.publications(self.resolve_topic_name(topic_name)))

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscribe to a topic."""
        run().scheduler.touch()
        return len(run().graph.subscriptions(self.resolve_topic_name(topic_name)))

    def _publish_event(self, event: Any) -> None:
        if self._event_publisher._publication.subscriptions:
            event.node = self.get_fully_qualified_name()
            self._event_publisher.publish(event)

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *error: object) -> None:
        self.destroy_node()


def _namespace(given: str) -> str:
    space = "/" + given.strip("/")
    if given != "/" and not re.fullmatch(r"(/|(/[A-Za-z_]\w*)+)", space, re.ASCII):
        raise InvalidNamespaceException(
            given,
            "namespace must hold nothing but alphanumerics, '_' and '/', and no part may start "
            "with a number",
            0,
        )
    return space


def _profile(given: QoSProfile | int) -> QoSProfile:
    if isinstance(given, QoSProfile):
        return given
    if isinstance(given, int):
        if given < 0:
            raise ValueError("history depth must be greater than or equal to zero")
        return QoSProfile(depth=given)
    raise TypeError(f"Expected QoSProfile or int, but received {type(given)!r}")


def _check_type(given: Any, attribute: str) -> None:
    if not hasattr(given, attribute) or not hasattr(given, "_ros_type"):
        raise NoTypeSupportImportedException(f"{given!r} is no interface class of ROS 2")


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, list | tuple) else value


def _full_type(name: str, kind: str) -> str:
    package, _, short = name.partition("/")
    return f"{package}/{kind}/{short}"


def _destroy(kept: list[Any], each: Any) -> bool:
    if each not in kept:
        return False
    kept.remove(each)
    each.destroy()
    return True
