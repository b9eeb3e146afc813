"""Subscriptions."""

from __future__ import annotations

import inspect
from collections import deque
from collections.abc import Callable
from enum import Enum
from typing import Any

from tracerisk.ros.messages.ros2 import copy_message
from tracerisk.ros.messages.ros2_wire import encode
from tracerisk.ros.readings.stale_messages import StaleMessages
from tracerisk.ros.time.clock import EPOCH_NS

from ._endpoint_events import EndpointEvents
from ._endpoint_times import span_ns
from ._entity import Call, Entity
from ._run import run
from .callback_groups import CallbackGroup
from .event_handler import SubscriptionEventCallbacks
from .executors import await_or_execute
from .qos import QoSProfile, misfit_of, reaches


class Subscription(Entity):
    """Receives messages of one type from a topic; made by `Node.create_subscription`.

    Messages wait in a queue as long as the profile's depth until an executor takes them.
    """

    class CallbackType(Enum):
        """What the callback is given."""

        MessageOnly = 0
        WithMessageInfo = 1

    def __init__(
        self,
        node: Any,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        callback_group: CallbackGroup,
        qos_profile: QoSProfile,
        raw: bool,
        event_callbacks: Any,
        given_name: str = "",
    ) -> None:
        super().__init__(node, callback_group)
        self.msg_type = msg_type
        self.topic = given_name or topic
        self.qos_profile = qos_profile
        self.raw = raw
        self.event_callbacks = event_callbacks
        self.callback = callback
        self._queue: deque[tuple[Any, dict[str, Any], int | None]] = deque(maxlen=qos_profile.kept)
        self._received = 0
        self._topic = topic
        if event_callbacks is None:
            event_callbacks = SubscriptionEventCallbacks()
        self.event_handlers = event_callbacks.create_event_handlers(
            callback_group, self, given_name or topic
        )
        self._events = EndpointEvents(node, self.event_handlers, qos_profile, self._heard)
        self._subscription = run().graph.subscribe(
            topic,
            msg_type._ros_type,
            self._deliver,
            node=node.get_fully_qualified_name(),
            takes_latched=qos_profile.is_latching,
        )
        run().graph.carrier.pass_work("end")
        self._events.watch(topic)

    @property
    def callback(self) -> Callable[..., Any]:
        """What is called with each message."""
        return self._callback

    @callback.setter
    def callback(self, value: Callable[..., Any]) -> None:
        self._callback = value
        self._callback_type = self.CallbackType.MessageOnly
        try:
            inspect.signature(value).bind(object())
        except TypeError:
            try:
                inspect.signature(value).bind(object(), object())
            except TypeError:
                raise RuntimeError(
                    "Subscription.__init__(): callback should be either be callable with one "
                    "argument(to get only the message) or two (to get message and message info)"
                ) from None
            self._callback_type = self.CallbackType.WithMessageInfo
        except ValueError:
            # A function of C has no signature to read; it takes the message.
            return

    @property
    def topic_name(self) -> str:
        """The topic's name, while the subscription is not destroyed."""
        with self.handle:
            return self._topic

    def get_publisher_count(self) -> int:
        """Return how many publishers it hears."""
        with self.handle:
            run().scheduler.touch()
        return len(self._heard())

    def _heard(self) -> list[Any]:
        ends = self._subscription.publications
        return [end for end in ends if reaches(end, self._subscription)]

    def destroy(self) -> None:
        """Leave the topic, and drop what waits."""
        self._events.close()
        super().destroy()
        self._subscription.close()
        self._queue.clear()

    def _deliver(self, message: Any, publication: Any) -> None:
        sender = getattr(publication.on_connect, "__self__", None)
        offered = getattr(sender, "qos_profile", None)
        if offered is not None and misfit_of(offered, self.qos_profile) is not None:
            return
        lifespan_ns = None if offered is None else span_ns(offered.lifespan)
        self._events.note_message()
        self._received += 1
        now_ns = EPOCH_NS + run().scheduler.now_ns
        info = {
            "source_timestamp": now_ns,
            "received_timestamp": now_ns,
            "publication_sequence_number": publication.sent,
            "reception_sequence_number": self._received,
        }
        expires_ns = None if lifespan_ns is None else run().scheduler.now_ns + lifespan_ns
        self._queue.append((message, info, expires_ns))

    def _is_ready(self) -> bool:
        return any(self._is_fresh(expires_ns) for _, _, expires_ns in self._queue)

    @staticmethod
    def _is_fresh(expires_ns: int | None) -> bool:
        return expires_ns is None or run().scheduler.now_ns <= expires_ns

    def _take(self, executor: Any) -> Call | None:
        while self._queue and not self._is_fresh(self._queue[0][2]):
            self._queue.popleft()
        if not self._queue:
            return None
        message, info, _ = self._queue.popleft()
        arguments: list[Any] = [encode(message) if self.raw else copy_message(message)]
        if self._callback_type is self.CallbackType.WithMessageInfo:
            arguments.append(info)

        came_ns = info["received_timestamp"] - EPOCH_NS
        # What waits now: a callback that is at work takes in none of it.
        waiting = [(later, told["received_timestamp"] - EPOCH_NS) for later, told, _ in self._queue]
        stale = run().runtime.client(StaleMessages)

        async def call() -> None:
            with stale.handling(self._subscription, message, came_ns, waiting, "a depth of 1"):
                await await_or_execute(self._callback, *arguments)

        return call
