"""What happens to a publisher or a subscription: others come, go, or do not fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ._endpoint_times import Watchdog, span_ns
from ._run import run
from .event_handler import (
    EventHandler,
    QoSLivelinessChangedInfo,
    QoSLivelinessLostInfo,
    QoSOfferedDeadlineMissedInfo,
    QoSPublisherEventType,
    QoSRequestedIncompatibleQoSInfo,
    QoSSubscriptionEventType,
    QoSSubscriptionMatchedInfo,
)
from .qos import QoSPolicyKind, QoSProfile

_MISFITS = (
    QoSPublisherEventType.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
)
_MATCHES = (
    QoSPublisherEventType.RCL_PUBLISHER_MATCHED,
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_MATCHED,
)


_DEADLINES = (
    QoSPublisherEventType.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED,
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED,
)
_CHANGES = (QoSSubscriptionEventType.RCL_SUBSCRIPTION_LIVELINESS_CHANGED,)
_LOSSES = (QoSPublisherEventType.RCL_PUBLISHER_LIVELINESS_LOST,)


class EndpointEvents:
    """Notifies the handlers of one endpoint of what happens to it; `node` runs their callbacks.

    `peers` returns who fits now, `profile` has the deadline between two messages.
    """

    def __init__(
        self,
        node: Any,
        handlers: list[EventHandler],
        profile: QoSProfile,
        peers: Callable[[], list[Any]],
    ) -> None:
        self._node = node
        self._handlers = handlers
        self._peers = peers
        self._lives: tuple[frozenset[int], frozenset[int]] = (frozenset(), frozenset())
        period_ns = span_ns(profile.deadline) if self._wants(_DEADLINES) else None
        self._deadline = Watchdog(
            period_ns,
            lambda count: self._report(_DEADLINES, QoSOfferedDeadlineMissedInfo(count, 1)),
        )
        self._misfits = 0
        self._matched: set[int] = set()
        self._total = 0

    def close(self) -> None:
        """Drop the handlers, for the endpoint is destroyed."""
        self._deadline.close()
        for handler in self._handlers:
            handler.destroy()
            self._node.remove_waitable(handler)
        self._handlers = []

    def note_misfit(self, policy: QoSPolicyKind) -> None:
        """Note that somebody of the topic has a profile that does not fit in a policy."""
        self._misfits += 1
        info = QoSRequestedIncompatibleQoSInfo(self._misfits, 1, policy)
        self._report(_MISFITS, info)

    def note_message(self) -> None:
        """Note that a message was sent, or has come."""
        self._deadline.sign()

    def note_loss(self, count: int) -> None:
        """Note that the publisher has shown no sign of life in time."""
        self._report(_LOSSES, QoSLivelinessLostInfo(count, 1))

    def watch(self, topic: str) -> None:
        """Look whenever somebody comes to the topic or leaves it, where a handler wants to know."""
        if not self._wants((*_MATCHES, *_CHANGES)):
            return

        def look(change: str, name: str, type_name: str) -> None:
            if name == topic:
                self._note_peers({id(peer) for peer in self._peers()})
                self.note_lives()

        run().graph.watch(look)

    def note_lives(self) -> None:
        """Look which publishers live."""
        if not self._wants(_CHANGES):
            return
        alive: set[int] = set()
        dead: set[int] = set()
        for publication in self._peers():
            publisher = getattr(publication.on_connect, "__self__", None)
            (alive if getattr(publisher, "_is_alive", True) else dead).add(id(publication))
        before = self._lives
        self._lives = frozenset(alive), frozenset(dead)
        if self._lives != before:
            changes = (len(now) - len(then) for now, then in zip(self._lives, before, strict=True))
            self._report(_CHANGES, QoSLivelinessChangedInfo(len(alive), len(dead), *changes))

    def _wants(self, kinds: tuple[Any, ...]) -> bool:
        return any(handler.event_type is kind for handler in self._handlers for kind in kinds)

    def _note_peers(self, now: set[int]) -> None:
        come, gone = len(now - self._matched), len(self._matched - now)
        if not come and not gone:
            return
        self._matched = now
        self._total += come
        self._report(_MATCHES, QoSSubscriptionMatchedInfo(self._total, come, len(now), come - gone))

    def _report(self, kinds: tuple[Any, ...], info: Any) -> None:
        for handler in self._handlers:
            if any(handler.event_type is kind for kind in kinds):
                handler._note(info)
                # Only then: most handlers of most endpoints never have anything to do.
                if handler not in self._node._waitables:
                    self._node.add_waitable(handler)
