"""How much of the calls of a service is published for others to look at."""

from __future__ import annotations

from enum import IntEnum
from operator import attrgetter
from typing import Any

from tracerisk.ros.time.clock import EPOCH_NS

from ._entity import Entity
from ._run import run
from .callback_groups import CallbackGroup
from .qos import QoSProfile


class ServiceIntrospectionState(IntEnum):
    """What is published of each call: nothing, that it was made, or what it says too."""

    OFF = 0
    METADATA = 1
    CONTENTS = 2


class ServiceEnd(Entity):
    """A client of a service, or what serves it."""

    def __init__(
        self,
        node: Any,
        srv_type: Any,
        srv_name: str,
        qos_profile: QoSProfile,
        callback_group: CallbackGroup,
    ) -> None:
        super().__init__(node, callback_group)
        self.srv_type = srv_type
        self._full_name = srv_name
        self.srv_name = srv_name
        """The name as it was given, neither expanded nor remapped."""
        self.qos_profile = qos_profile
        self._introspection = Introspection(node, srv_type, srv_name)

    service_name = property(attrgetter("_full_name"), doc="The service's name.")

    def configure_introspection(
        self, clock: Any, service_event_qos_profile: QoSProfile, introspection_state: Any
    ) -> None:
        """Publish the calls on `SERVICE/_service_event`, as much of them as the state says."""
        self._introspection.configure(service_event_qos_profile, introspection_state)


class Introspection:
    """Publishes the calls of one end of a service on `SERVICE/_service_event`."""

    def __init__(self, node: Any, srv_type: Any, srv_name: str) -> None:
        self._node = node
        self._srv_type = srv_type
        self._topic = f"{srv_name}/_service_event"
        self._state = ServiceIntrospectionState.OFF
        self._publisher: Any = None

    def configure(self, qos_profile: Any, state: ServiceIntrospectionState) -> None:
        """Publish as much as `state` says, from now on."""
        self._state = ServiceIntrospectionState(state)
        if self._publisher is not None:
            self._node.destroy_publisher(self._publisher)
            self._publisher = None
        if self._state is not ServiceIntrospectionState.OFF:
            self._publisher = self._node.create_publisher(
                self._srv_type.Event, self._topic, qos_profile
            )

    def report(self, kind: str, number: int, **said: Any) -> None:
        """Publish a step of a call: `REQUEST_SENT` and the like of ServiceEventInfo."""
        if self._publisher is None:
            return
        event = self._srv_type.Event()
        event.info.event_type = getattr(event.info, kind)
        event.info.sequence_number = number
        now_ns = EPOCH_NS + run().scheduler.now_ns
        event.info.stamp.sec, event.info.stamp.nanosec = divmod(now_ns, 1_000_000_000)
        if self._state is ServiceIntrospectionState.CONTENTS:
            for name, message in said.items():
                setattr(event, name, [message])
        self._publisher.publish(event)
