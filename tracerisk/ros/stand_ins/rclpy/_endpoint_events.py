"""What happens to a publisher or a subscription: others come, go, or do not fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ._run import run
from .event_handler import (
    EventHandler,
    QoSPublisherEventType,
    QoSRequestedIncompatibleQoSInfo,
    QoSSubscriptionEventType,
    QoSSubscriptionMatchedInfo,
)
from .qos import QoSPolicyKind

_MISFITS = (
    QoSPublisherEventType.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
)
_MATCHES = (
    QoSPublisherEventType.RCL_PUBLISHER_MATCHED,
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_MATCHED,
)


class EndpointEvents:
    """Notifies the handlers of one endpoint of what happens to it; `node` runs their callbacks."""

    def __init__(self, node: Any, handlers: list[EventHandler]) -> None:
        self._node = node
        self._handlers = handlers
        self._misfits = 0
        self._matched: set[int] = set()
        self._total = 0

    def close(self) -> None:
        """Drop the handlers, for the endpoint is destroyed."""
        for handler in self._handlers:
            handler.destroy()
            self._node.remove_waitable(handler)
        self._handlers = []

    def note_misfit(self, policy: QoSPolicyKind) -> None:
        """Note that somebody of the topic has a profile that does not fit in a policy."""
        self._misfits += 1
        info = QoSRequestedIncompatibleQoSInfo(self._misfits, 1, policy)
        self._report(_MISFITS, info)

    def watch(self, topic: str, peers: Callable[[], list[Any]]) -> None:
        """Look whenever somebody comes to the topic or leaves it, where a handler wants to know.

        `peers` returns who fits now.
        """
        if not any(each.event_type is kind for each in self._handlers for kind in _MATCHES):
            return

        def look(change: str, name: str, type_name: str) -> None:
            if name == topic:
                self._note_peers({id(each) for each in peers()})

        run().graph.watch(look)

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
