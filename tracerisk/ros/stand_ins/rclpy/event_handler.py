"""Callbacks for events of an endpoint: that others came or went, or do not fit.

Losses of messages are not simulated: no such event happens.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar

from ._entity import Call
from .callback_groups import CallbackGroup
from .executors import await_or_execute
from .logging import get_logger
from .qos import QoSPolicyKind, qos_policy_name_from_kind
from .waitable import NumberOfEntities, Waitable


class QoSPublisherEventType(IntEnum):
    """The events of a publisher; the numbers are those of rcl."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class QoSSubscriptionEventType(IntEnum):
    """The events of a subscription; the numbers are those of rcl."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


@dataclass
class _Count:
    """A count of events."""

    total_count: int = 0
    """The number of events since the beginning."""
    total_count_change: int = 0
    """The number of events since the last callback."""


class QoSRequestedDeadlineMissedInfo(_Count):
    """How many messages came too late."""


class QoSOfferedDeadlineMissedInfo(_Count):
    """How many messages were sent too late."""


class QoSLivelinessLostInfo(_Count):
    """How often a publisher did not show that it lives."""


class QoSMessageLostInfo(_Count):
    """How many messages were lost."""


class IncompatibleTypeInfo(_Count):
    """How many endpoints of the topic have another type."""


@dataclass
class QoSLivelinessChangedInfo:
    """The numbers of publishers by liveliness."""

    alive_count: int = 0
    """The number of publishers that are alive."""
    not_alive_count: int = 0
    """The number of publishers that are not alive."""
    alive_count_change: int = 0
    """The change of `alive_count` since the last callback."""
    not_alive_count_change: int = 0
    """The change of `not_alive_count` since the last callback."""


@dataclass
class QoSRequestedIncompatibleQoSInfo(_Count):
    """The number of endpoints of the topic with an incompatible profile."""

    last_policy_kind: QoSPolicyKind = QoSPolicyKind.INVALID
    """The policy in which the last of them is incompatible."""


QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo


@dataclass
class QoSSubscriptionMatchedInfo(_Count):
    """The number of matching endpoints of the topic."""

    current_count: int = 0
    """The number of endpoints that match at present."""
    current_count_change: int = 0
    """The change of `current_count` since the last callback."""


QoSPublisherMatchedInfo = QoSSubscriptionMatchedInfo


class EventHandler(Waitable):
    """Calls back on one kind of events of an endpoint, when an executor looks for work."""

    def __init__(
        self,
        *,
        callback_group: CallbackGroup,
        callback: Callable[[Any], Any],
        event_type: IntEnum,
        parent_impl: Any,
    ) -> None:
        super().__init__(callback_group)
        self.callback = callback
        self.event_type = event_type
        self._info: Any = None

    def get_num_entities(self) -> NumberOfEntities:
        """Return how many entities of each kind it is made of."""
        return NumberOfEntities(num_events=1)

    def _note(self, info: Any) -> None:
        """Take what has happened; the callback is given the last of what it did not get yet."""
        self._info = info

    def _is_ready(self) -> bool:
        return self._info is not None

    def _take(self, executor: Any) -> Call | None:
        info, self._info = self._info, None

        async def call() -> None:
            await await_or_execute(self.callback, info)

        return call


QoSEventHandler = EventHandler
"""The older name."""


class _EventCallbacks:
    """What is called on the events of an endpoint; None where nothing is."""

    _kinds: ClassVar[dict[str, IntEnum]]
    _text: ClassVar[dict[str, str]]
    use_default_callbacks: bool

    def _handlers(
        self, callback_group: CallbackGroup, endpoint: Any, topic_name: str
    ) -> Iterator[EventHandler]:
        for name, kind in self._kinds.items():
            callback = getattr(self, name)
            if callback is None and self.use_default_callbacks and name in self._text:
                callback = _warning(endpoint, self._text[name], topic_name)
            if callback is not None:
                yield EventHandler(
                    callback_group=callback_group,
                    callback=callback,
                    event_type=kind,
                    parent_impl=endpoint,
                )


def _warning(endpoint: Any, text: str, topic_name: str) -> Callable[[Any], None]:
    def warn(info: Any) -> None:
        kind = getattr(info, "last_policy_kind", QoSPolicyKind.INVALID)
        policy = qos_policy_name_from_kind(kind)
        get_logger(endpoint._node.get_logger().name).warn(
            text.format(topic=topic_name, policy=policy)
        )

    return warn


class SubscriptionEventCallbacks(_EventCallbacks):
    """What is called on events of a subscription."""

    _kinds: ClassVar[dict[str, IntEnum]] = {
        "deadline": QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED,
        "incompatible_qos": QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
        "liveliness": QoSSubscriptionEventType.RCL_SUBSCRIPTION_LIVELINESS_CHANGED,
        "message_lost": QoSSubscriptionEventType.RCL_SUBSCRIPTION_MESSAGE_LOST,
        "incompatible_type": QoSSubscriptionEventType.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE,
        "matched": QoSSubscriptionEventType.RCL_SUBSCRIPTION_MATCHED,
    }
    _text: ClassVar[dict[str, str]] = {
        "incompatible_qos": (
            "New publisher discovered on topic '{topic}', offering incompatible QoS. "
            "No messages will be received from it. Last incompatible policy: {policy}"
        ),
        "incompatible_type": (
            "Incompatible type on topic '{topic}', no messages will be received from it."
        ),
    }

    def __init__(
        self,
        *,
        deadline: Callable[[Any], None] | None = None,
        incompatible_qos: Callable[[Any], None] | None = None,
        liveliness: Callable[[Any], None] | None = None,
        message_lost: Callable[[Any], None] | None = None,
        incompatible_type: Callable[[Any], None] | None = None,
        matched: Callable[[Any], None] | None = None,
        use_default_callbacks: bool = True,
    ) -> None:
        self.deadline = deadline
        self.incompatible_qos = incompatible_qos
        self.liveliness = liveliness
        self.message_lost = message_lost
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks

    def create_event_handlers(
        self, callback_group: CallbackGroup, subscription: Any, topic_name: str
    ) -> list[EventHandler]:
        """Return a handler for each callback, and those that warn of what does not fit."""
        return list(self._handlers(callback_group, subscription, topic_name))


class PublisherEventCallbacks(_EventCallbacks):
    """What is called on events of a publisher."""

    _kinds: ClassVar[dict[str, IntEnum]] = {
        "deadline": QoSPublisherEventType.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED,
        "liveliness": QoSPublisherEventType.RCL_PUBLISHER_LIVELINESS_LOST,
        "incompatible_qos": QoSPublisherEventType.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
        "incompatible_type": QoSPublisherEventType.RCL_PUBLISHER_INCOMPATIBLE_TYPE,
        "matched": QoSPublisherEventType.RCL_PUBLISHER_MATCHED,
    }
    _text: ClassVar[dict[str, str]] = {
        "incompatible_qos": (
            "New subscription discovered on topic '{topic}', requesting incompatible QoS. "
            "No messages will be sent to it. Last incompatible policy: {policy}"
        ),
        "incompatible_type": (
            "Incompatible type on topic '{topic}', no messages will be sent to it."
        ),
    }

    def __init__(
        self,
        *,
        deadline: Callable[[Any], None] | None = None,
        liveliness: Callable[[Any], None] | None = None,
        incompatible_qos: Callable[[Any], None] | None = None,
        incompatible_type: Callable[[Any], None] | None = None,
        matched: Callable[[Any], None] | None = None,
        use_default_callbacks: bool = True,
    ) -> None:
        self.deadline = deadline
        self.liveliness = liveliness
        self.incompatible_qos = incompatible_qos
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks

    def create_event_handlers(
        self, callback_group: CallbackGroup, publisher: Any, topic_name: str
    ) -> list[EventHandler]:
        """Return a handler for each callback, and those that warn of what does not fit."""
        return list(self._handlers(callback_group, publisher, topic_name))
