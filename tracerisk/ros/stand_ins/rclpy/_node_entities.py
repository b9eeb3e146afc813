"""What a node makes and destroys: publishers, subscriptions, services, timers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from typing import Any

from ._handle import OF_CONTEXT, check_context
from ._node_names import NodeNames
from ._run import run
from .callback_groups import CallbackGroup
from .client import Client
from .clock import Clock
from .constants import S_TO_NS
from .context import Context
from .guard_condition import GuardCondition
from .publisher import Publisher
from .qos import QoSProfile, qos_profile_parameters, qos_profile_services_default
from .qos_overriding_options import _declare_qos_parameters
from .service import LibraryService, Service
from .subscription import Subscription
from .timer import Rate, Timer
from .type_support import check_is_valid_msg_type, check_is_valid_srv_type

OF_ACTION = "/_action/"
"""What the names of an action's services and topics hold."""
KEPT = (
    *("_rates", "_publishers", "_subscriptions", "_clients"),
    *("_services", "_timers", "_guards", "_waitables"),
)
"""The lists of what a node has made, in the order in which it is destroyed."""


def _each(name: str, doc: str) -> Any:
    """Return a property that yields what is in one of the lists."""

    def read(node: NodeEntities) -> Iterator[Any]:
        yield from getattr(node, name)

    return property(read, doc=doc)


class NodeEntities(NodeNames):
    """What a node makes; a part of `Node`."""

    _publishers: list[Publisher]
    _subscriptions: list[Subscription]
    _clients: list[Client]
    _services: list[Service]
    _timers: list[Timer]
    _guards: list[GuardCondition]
    _waitables: list[Any]
    _rates: list[Rate]
    _default_callback_group: CallbackGroup
    _rate_group: CallbackGroup
    _clock: Clock
    _context: Context

    def _entities(self) -> Iterator[Any]:
        """Return what an executor asks for work, in the order of rclpy."""
        yield from tuple(self._timers)
        yield from tuple(self._subscriptions)
        yield from tuple(self._guards)
        yield from tuple(self._clients)
        yield from tuple(self._services)

    publishers = _each("_publishers", "The publishers.")
    subscriptions = _each("_subscriptions", "The subscriptions.")
    clients = _each("_clients", "The clients of services.")
    services = _each("_services", "The services.")
    timers = _each("_timers", "The timers.")
    guards = _each("_guards", "The guard conditions.")
    waitables = _each("_waitables", "The clients and servers of actions.")

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
            AttributeError: `msg_type` is no interface class of ROS 2.
            RuntimeError: it is one of another kind.
        """
        check_is_valid_msg_type(msg_type)
        name = self.resolve_topic_name(topic)
        self._check_usable("Failed to create publisher")
        made = publisher_class(
            self,
            msg_type,
            name,
            self._overridden(publisher_class, name, qos_profile, qos_overriding_options),
            event_callbacks,
            callback_group or self._default_callback_group,
            topic,
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
        check_is_valid_msg_type(msg_type)
        name = self.resolve_topic_name(topic)
        self._check_usable("Failed to create subscription")
        made = Subscription(
            self,
            msg_type,
            name,
            callback,
            callback_group or self._default_callback_group,
            self._overridden(Subscription, name, qos_profile, qos_overriding_options),
            raw,
            event_callbacks,
            topic,
        )
        self._subscriptions.append(made)
        if OF_ACTION in name:
            run().action_services.ask(name, msg_type)
        return made

    def _overridden(
        self, kind: type, name: str, given: QoSProfile | int, options: Any
    ) -> QoSProfile:
        profile = _profile(given)
        if options is None:
            return profile

        profile = copy(profile)
        _declare_qos_parameters(kind, self, name, profile, options)
        return profile

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
            AttributeError: `srv_type` is no interface class of ROS 2.
            RuntimeError: it is one of another kind.
        """
        check_is_valid_srv_type(srv_type)
        self._check_usable("failed to create client")
        made = Client(
            self,
            srv_type,
            self.resolve_service_name(srv_name),
            qos_profile,
            callback_group or self._default_callback_group,
        )
        made.srv_name = srv_name
        self._clients.append(made)
        if OF_ACTION in made._full_name:
            run().action_services.ask(made._full_name, srv_type)
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
            AttributeError: `srv_type` is no interface class of ROS 2.
            RuntimeError: it is one of another kind.
        """
        check_is_valid_srv_type(srv_type)
        self._check_usable("failed to create service")
        made = Service(
            self,
            srv_type,
            self.resolve_service_name(srv_name),
            callback,
            callback_group or self._default_callback_group,
            qos_profile,
        )
        made.srv_name = srv_name
        self._services.append(made)
        return made

    def _create_own_service(
        self, srv_type: Any, srv_name: str, callback: Callable[[Any, Any], Any]
    ) -> None:
        made = LibraryService(
            self,
            srv_type,
            self.resolve_service_name(srv_name),
            callback,
            self._default_callback_group,
            qos_profile_parameters,
        )
        made.srv_name = srv_name.replace("~", self._name)
        self._services.append(made)

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[..., Any] | None,
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Make a timer of a period in seconds.

        Raises:
            RCLError: the context was shut down.
        """
        check_context(self._context, "failed to create timer", OF_CONTEXT)
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
        """Make a guard condition.

        Raises:
            RCLError: the context was shut down.
        """
        check_context(self._context, "failed to create guard_condition", OF_CONTEXT)
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


def _profile(given: QoSProfile | int) -> QoSProfile:
    if isinstance(given, QoSProfile):
        return given
    if isinstance(given, int):
        if given < 0:
            raise ValueError("history depth must be greater than or equal to zero")
        return QoSProfile(depth=given)
    raise TypeError(f"Expected QoSProfile or int, but received {type(given)!r}")


def _destroy(kept: list[Any], each: Any) -> bool:
    if each not in kept:
        return False
    kept.remove(each)
    each.destroy()
    return True
