"""Publishers and subscribers."""

from __future__ import annotations

import traceback
import warnings
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

from tracerisk.ros.graph.callback_thread import CallbackThread
from tracerisk.ros.graph.failures import callback_failed
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.graph.topic_ends import Publication, Subscription
from tracerisk.ros.messages.ros1_base import Message, SerializationError, copy_message
from tracerisk.ros.readings.stale_messages import StaleMessages
from tracerisk.ros.robot.bring_up.assumed_listeners import AssumedListeners

from . import core
from ._node import node
from .exceptions import ROSException, ROSSerializationException
from .msg import args_kwds_to_message, sent_copy
from .names import _warn_unless_legal, resolve_name, resolve_name_without_node_name

__all__ = ["Message", "Publisher", "SubscribeListener", "Subscriber", "Topic"]

DEFAULT_BUFF_SIZE = 65536


class Topic:
    """What publishers and subscribers have in common.

    Raises:
        ValueError: the name is empty, or `data_class` is not a message class.
    """

    impl: Any = None

    def __init__(self, name: str, data_class: Any, reg_type: str) -> None:
        if not name or not isinstance(name, str):
            raise ValueError("topic name is not a non-empty string")
        _check_class(data_class)
        _warn_unless_legal(name, 3)
        is_ready = node().is_initialized
        self.resolved_name: Any = (
            resolve_name(name) if is_ready else resolve_name_without_node_name(name)
        )
        self.name = self.resolved_name
        self.data_class: Any = data_class
        self.type = self.data_class._type
        self.md5sum = self.data_class._md5sum
        self.reg_type = reg_type

    def get_num_connections(self) -> int:
        """Return how many nodes are connected to this end of the topic."""
        node().scheduler.touch()
        return 0 if self.impl is None else int(self.impl.get_num_connections())

    def unregister(self) -> None:
        """Leave the topic; a second call does nothing."""
        if self.impl is not None:
            self.impl.release()
            # As there: a topic that was left knows nothing of itself any more.
            self.impl = self.resolved_name = self.type = self.md5sum = self.data_class = None


def _check_class(data_class: Any) -> None:
    if data_class is None:
        raise ValueError("topic parameter 'data_class' is not initialized")
    if not isinstance(data_class, type):
        raise ValueError(f"data_class [{data_class}] is not a class")
    if not issubclass(data_class, Message):
        raise ValueError(f"data_class [{data_class.__name__}] is not a message data class")


class SubscribeListener:
    """Called when subscribers connect to a publisher and leave it."""

    def peer_subscribe(
        self,
        topic_name: str,
        topic_publish: Callable[[Any], None],
        peer_publish: Callable[[Any], None],
    ) -> None:
        """Take a new subscriber; `peer_publish` sends to it alone."""

    def peer_unsubscribe(self, topic_name: str, num_peers: int) -> None:
        """Take that a subscriber left; `num_peers` remain."""


class Publisher(Topic):
    """Publish messages of `data_class` on a topic.

    `latch` keeps the last message for those who subscribe later.
    """

    def __init__(
        self,
        name: str,
        data_class: Any,
        subscriber_listener: SubscribeListener | None = None,
        tcp_nodelay: bool = False,
        latch: bool = False,
        headers: dict[str, str] | None = None,
        queue_size: int | None = None,
    ) -> None:
        super().__init__(name, data_class, "pub")
        state = node()
        if self.resolved_name not in state.publishers:
            state.publishers[self.resolved_name] = _PublisherImpl(self.resolved_name, data_class)
        self.impl = state.publishers[self.resolved_name]
        self.impl.references += 1
        if subscriber_listener is not None:
            self.impl.add_listener(subscriber_listener)
        if latch:
            self.impl.publication.latch = True
        if queue_size is None:
            warnings.warn(
                "The publisher should be created with an explicit keyword argument 'queue_size'.",
                SyntaxWarning,
                stacklevel=2,
            )

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Publish a message, or one made of these fields.

        Raises:
            ROSException: the node is not initialized, or the publisher is unregistered.
            ROSSerializationException: a field holds what its type cannot take.
            TypeError: the arguments make no message of the topic's type.
        """
        if self.impl is None:
            raise ROSException("publish() to an unregistered() handle")
        state = node()
        if not state.is_initialized:
            raise ROSException(
                "ROS node has not been initialized yet. Please call init_node() first"
            )
        message = args_kwds_to_message(self.data_class, args, kwds)
        try:
            self.impl.publish(message)
        except SerializationError as error:
            raise ROSSerializationException(str(error)) from error


class _Connected:
    """The node's one connection to a topic, which ends with the last that refers to it."""

    def __init__(self, name: str, data_class: Any) -> None:
        self.name = name
        self.data_class = data_class
        self.references = 0

    def release(self) -> None:
        self.references -= 1
        if self.references == 0:
            self.close()

    def close(self) -> None:
        raise NotImplementedError


class _PublisherImpl(_Connected):
    """The node's one connection to a topic that it publishes on."""

    def __init__(self, name: str, data_class: Any) -> None:
        super().__init__(name, data_class)
        state = node()
        self.listeners: list[SubscribeListener] = []
        self.publication: Publication = state.graph.advertise(
            name,
            data_class._type,
            node=state.name,
            copy=self._copy,
            on_connect=self._connected,
            on_disconnect=self._disconnected,
        )

    def publish(self, message: Any, only: Subscription | None = None) -> None:
        if self.publication.closed:
            if not node().is_shutdown:
                raise ROSException("publish() to a closed topic")
            return
        self.publication.publish(message, only)

    def get_num_connections(self) -> int:
        return current().client(AssumedListeners).count(self.publication)

    def add_listener(self, listener: SubscribeListener) -> None:
        self.listeners.append(listener)

    def close(self) -> None:
        self.publication.close()
        node().publishers.pop(self.name, None)

    def _copy(self, message: Any) -> Any:
        if getattr(type(message), "_has_header", False):
            message.header.seq = self.publication.sent + 1
        return sent_copy(message, self.data_class)

    def _connected(self, subscription: Subscription) -> None:
        for listener in list(self.listeners):
            listener.peer_subscribe(
                self.name, self.publish, lambda message: self.publish(message, subscription)
            )

    def _disconnected(self, subscription: Subscription) -> None:
        for listener in list(self.listeners):
            listener.peer_unsubscribe(self.name, len(self.publication.subscriptions))


class Subscriber(Topic):
    """Call `callback` with each message of a topic, on a thread of the topic's own."""

    def __init__(
        self,
        name: str,
        data_class: Any,
        callback: Callable[..., object] | None = None,
        callback_args: Any = None,
        queue_size: int | None = None,
        buff_size: int = DEFAULT_BUFF_SIZE,
        tcp_nodelay: bool = False,
    ) -> None:
        super().__init__(name, data_class, "sub")
        state = node()
        if self.resolved_name not in state.subscribers:
            state.subscribers[self.resolved_name] = _SubscriberImpl(self.resolved_name, data_class)
        self.impl = state.subscribers[self.resolved_name]
        self.impl.references += 1
        if queue_size is not None:
            self.impl.set_queue_size(queue_size)
        if buff_size != DEFAULT_BUFF_SIZE and (type(buff_size) is not int or buff_size <= 0):
            raise ROSException("buffer size must be a positive integer")
        self.callback = callback
        self.callback_args = callback_args
        if callback is not None:
            self.impl.add_callback(callback, callback_args)
        self.impl.connect()

    def unregister(self) -> None:
        """Leave the topic; messages that wait are dropped."""
        if self.impl is not None:
            if self.callback is not None:
                self.impl.remove_callback(self.callback, self.callback_args)
            self.callback = self.callback_args = None
        super().unregister()


class _Connection:
    """What comes from one publisher: its own thread, and the last message if it is latched."""

    def __init__(self, thread: CallbackThread) -> None:
        self.thread = thread
        self.latched: Any = None
        self.waiting: list[tuple[Any, int]] = []

    def trim(self) -> None:
        """Forget of the messages that wait those that the thread has dropped or taken."""
        del self.waiting[: len(self.waiting) - self.thread.n_waiting]


class _SubscriberImpl(_Connected):
    """The node's one connection to a topic that it subscribes to, with all its callbacks."""

    def __init__(self, name: str, data_class: Any) -> None:
        super().__init__(name, data_class)
        self.queue_size: int | None = None
        self.callbacks: list[tuple[Callable[..., object], Any]] = []
        self.subscription: Subscription | None = None
        self._connections: dict[Publication, _Connection] = {}

    def connect(self) -> None:
        # After the first callback is known, so that a latched message finds it.
        if self.subscription is None:
            state = node()
            self.subscription = state.graph.subscribe(
                self.name,
                self.data_class._type,
                self._deliver,
                node=state.name,
                on_disconnect=self._disconnected,
            )

    def set_queue_size(self, queue_size: int) -> None:
        if queue_size == 0:
            raise ROSException("queue size may not be set to zero")
        if type(queue_size) is not int:
            raise ROSException("queue size must be an integer")
        self.queue_size = None if queue_size == -1 else queue_size
        for connection in self._connections.values():
            connection.thread.limit = self.queue_size

    def add_callback(self, callback: Callable[..., object], args: Any) -> None:
        self.callbacks = [*self.callbacks, (callback, args)]
        for connection in self._connections.values():
            if connection.latched is not None:
                tracer = node().runtime.tracer
                root: Any = tracer.root("callback") if tracer is not None else nullcontext()
                with root:
                    self._invoke(connection.latched, callback, args)

    def remove_callback(self, callback: Callable[..., object], args: Any) -> None:
        for index, (known, known_args) in enumerate(self.callbacks):
            if known == callback and known_args == args:
                self.callbacks = self.callbacks[:index] + self.callbacks[index + 1 :]
                return
        raise KeyError("no matching cb")

    def get_num_connections(self) -> int:
        return 0 if self.subscription is None else len(self.subscription.publications)

    def close(self) -> None:
        if self.subscription is not None:
            self.subscription.close()
        for connection in self._connections.values():
            connection.thread.close()
        node().subscribers.pop(self.name, None)

    def _disconnected(self, publication: Publication) -> None:
        # What it sent before it left is still delivered, as from a socket.
        self._connections.pop(publication, None)

    def _deliver(self, snapshot: Any, publication: Publication) -> None:
        connection = self._connections.get(publication)
        if connection is None:
            state = node()
            thread = CallbackThread(
                state.scheduler,
                state.runtime.tracer,
                f"subscriber {self.name}",
                limit=self.queue_size,
            )
            connection = self._connections[publication] = _Connection(thread)
        arrived, came_ns = connection, node().scheduler.now_ns
        arrived.thread.put(lambda: self._receive(snapshot, publication, arrived, came_ns))
        arrived.waiting.append((snapshot, came_ns))
        arrived.trim()

    def _receive(
        self, snapshot: Any, publication: Publication, connection: _Connection, came_ns: int
    ) -> None:
        connection.trim()
        if type(snapshot) is self.data_class:
            message = copy_message(snapshot)
        else:
            message = sent_copy(snapshot, self.data_class)
        message._connection_header = {
            "callerid": publication.node,
            "latching": "1" if publication.latch else "0",
            "md5sum": type(snapshot)._md5sum,
            "topic": self.name,
            "type": publication.type_name,
        }
        connection.latched = message if publication.latch else None
        stale = node().runtime.client(StaleMessages)
        with stale.handling(
            self.subscription, snapshot, came_ns, connection.waiting, "queue_size=1"
        ):
            for callback, args in self.callbacks:
                self._invoke(message, callback, args)

    def _invoke(self, message: Any, callback: Callable[..., object], args: Any) -> None:
        state = node()
        try:
            if args is not None:
                callback(message, args)
            else:
                callback(message)
        except Exception as error:  # noqa: BLE001 - the controller's; rospy logs it and goes on
            if state.is_shutdown:
                return
            entry = error.__traceback__.tb_next if error.__traceback__ is not None else None
            shown = "".join(traceback.format_exception(type(error), error, entry))
            core.logerr("bad callback: %s\n%s", _name_of(callback), shown.rstrip())
            callback_failed(f"a callback of {self.name}", error)


def _name_of(callback: Callable[..., object]) -> str:
    # The representation of a function shows its address, which no two runs share.
    return str(getattr(callback, "__qualname__", type(callback).__name__))
