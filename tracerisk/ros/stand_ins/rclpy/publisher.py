"""Publishers."""

from __future__ import annotations

from collections import deque
from typing import Any

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.messages.ros2 import copy_message
from tracerisk.ros.robot.bring_up.assumed_listeners import AssumedListeners

from ._endpoint_events import EndpointEvents
from ._endpoint_times import Watchdog, span_ns
from ._handle import OF_PUBLISHER, Handle, check_context
from ._run import run
from .callback_groups import CallbackGroup
from .duration import Duration
from .event_handler import PublisherEventCallbacks
from .qos import LivelinessPolicy, QoSProfile, misfit_of, reaches
from .serialization import deserialize_message


class Publisher:
    """Sends messages of one type to a topic; made by `Node.create_publisher`."""

    def __init__(
        self,
        node: Any,
        msg_type: Any,
        topic: str,
        qos_profile: QoSProfile,
        event_callbacks: Any,
        callback_group: CallbackGroup,
        given_name: str = "",
    ) -> None:
        self.msg_type = msg_type
        self.topic = given_name or topic
        self.qos_profile = qos_profile
        self.event_callbacks = event_callbacks
        self.callback_group = callback_group
        self.handle = Handle()
        self._node = node
        if event_callbacks is None:
            event_callbacks = PublisherEventCallbacks()
        self.event_handlers = event_callbacks.create_event_handlers(
            callback_group, self, given_name or topic
        )
        self._events = EndpointEvents(node, self.event_handlers, qos_profile, self._reached)
        is_manual = qos_profile.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC
        lease_ns = span_ns(qos_profile.liveliness_lease_duration) if is_manual else None
        self._is_alive = True
        self._life = Watchdog(lease_ns, self._lost, once=True)
        self._history: deque[tuple[Any, int]] = deque(maxlen=qos_profile.kept)
        self._publication = run().graph.advertise(
            topic,
            msg_type._ros_type,
            node=node.get_fully_qualified_name(),
            # Each receiver has a message of its own, as one that came over a wire.
            copy=lambda message: message,
            on_connect=self._send_history,
        )
        self._publication.has_history = qos_profile.is_latching
        run().graph.carrier.pass_work("end")
        self._events.watch(topic)
        self._life.sign()

    @property
    def topic_name(self) -> str:
        """The topic's name, while the publisher is not destroyed."""
        with self.handle:
            name: str = self._publication.topic
        return name

    def publish(self, msg: Any) -> None:
        """Send a message, or the bytes of one.

        Raises:
            TypeError: it is of another class.
            InvalidHandle: the publisher was destroyed.
            RCLError: the context was shut down.
        """
        with self.handle:
            self._check_context("Failed to publish")
        if isinstance(msg, bytes):
            msg = deserialize_message(msg, self.msg_type)
        if not isinstance(msg, self.msg_type):
            raise TypeError(f"Expected {self.msg_type}, got {type(msg)}")
        sent = copy_message(msg)
        if self.qos_profile.is_latching:
            self._history.append((sent, run().scheduler.now_ns))
        self._events.note_message()
        self._live(is_alive=True)
        self._publication.publish(sent)

    def _live(self, *, is_alive: bool) -> None:
        """Show a sign of life, or none in time; its subscriptions look at a change."""
        if is_alive:
            self._life.sign()
        if is_alive == self._is_alive:
            return
        self._is_alive = is_alive
        for subscription in self._publication.subscriptions:
            events = getattr(getattr(subscription.deliver, "__self__", None), "_events", None)
            if events is not None:
                events.note_lives()

    def _lost(self, count: int) -> None:
        self._events.note_loss(count)
        self._live(is_alive=False)

    def get_subscription_count(self) -> int:
        """Return how many subscriptions it reaches."""
        with self.handle:
            self._check_context("failed to get subscription count")
        run().scheduler.touch()
        current().client(AssumedListeners).count(self._publication)
        return len(self._reached())

    def _reached(self) -> list[Any]:
        ends = self._publication.subscriptions
        return [end for end in ends if reaches(self._publication, end)]

    def assert_liveliness(self) -> None:
        """Show a sign of life; one that was lost comes back only with a message."""
        with self.handle:
            self._check_context("Failed to assert liveliness on the Publisher")
        if self._is_alive:
            self._life.sign()

    def wait_for_all_acked(self, timeout: Duration | None = None) -> bool:
        """Return True: every message has arrived."""
        with self.handle:
            self._check_context("Failed to wait for all acknowledgements")
        return True

    def _check_context(self, doing: str) -> None:
        check_context(self._node.context, doing, OF_PUBLISHER)

    def destroy(self) -> None:
        """Leave the topic."""
        self._events.close()
        self._life.close()
        self._publication.close()
        self.handle.destroy_when_not_in_use()

    def _send_history(self, subscription: Any) -> None:
        # Late comers get what was sent, if they ask for it; the twin's own always do.
        receiver: Any = getattr(subscription.deliver, "__self__", None)
        asked = getattr(receiver, "qos_profile", None)
        if asked is not None:
            misfit = misfit_of(self.qos_profile, asked)
            if misfit is not None:
                receiver._events.note_misfit(misfit)
                self._events.note_misfit(misfit)
                recorder = current().recorder
                if recorder is not None:
                    recorder.finding(
                        "qos_misfit",
                        f"this subscription of {subscription.topic} gets nothing of the program's "
                        f"own publisher: their {misfit.name} does not fit",
                        subscription.place,
                        object_name=subscription.topic,
                    )
                return
            if not asked.is_latching:
                subscription.has_missed_latched |= bool(self._history)
                return
        lifespan_ns = span_ns(self.qos_profile.lifespan)
        for message, sent_ns in self._history:
            if lifespan_ns is None or run().scheduler.now_ns <= sent_ns + lifespan_ns:
                subscription.deliver(message, self._publication)
