"""What of the twin's graph real ROS sees, and what of real ROS reaches the twin's graph.

The twin's own servers are written against the graph of the stand-ins. Here a message of the one is
a message of the other by its bytes: topics, services and parameters are passed on as they come, and
a command belongs to the function that sent it by the stack that the controller's process sends.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.errors import InputError
from tracerisk.instrument.tracer import Frame
from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.graph_names import ANY_TYPE
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.topic_ends import Publication, Subscription
from tracerisk.ros.live.hooks import digest, frames_of
from tracerisk.ros.live.link import Link
from tracerisk.ros.live.ros2.action_bridge import ActionBridge
from tracerisk.ros.live.senders import Senders
from tracerisk.ros.live.wire import wire_of
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.time.clock import EPOCH_NS

if TYPE_CHECKING:
    from tracerisk.ros.messages.ros1 import Interfaces
    from tracerisk.ros.messages.ros2 import Interfaces2

CLOCK = "/clock"
_CLOCK_TYPE = "rosgraph_msgs/Clock"
_OF_LOGGING = ("/rosout", "/rosout_agg")
_TO_SERVERS = ("/goal", "/cancel")
"""The ends of the topics that servers of actions subscribe to in ROS 1."""


class Bridge:
    """Passes on topics, services and parameters between a graph and a relay in real ROS.

    `message` and `service` classes come from `interfaces`. `report` gets the words for what cannot
    be passed on, `acts` the number of the controller's thread that has sent what comes next.
    `sender` (an attribute) returns the functions that sent what has come, by its topic or service,
    its bytes, and, if known, its number among those of its publisher and when it was sent [ns since
    1970]; at first those that `sent` has noted.
    """

    def __init__(
        self,
        runtime: Runtime,
        interfaces: Interfaces | Interfaces2,
        relay: Link,
        report: Callable[[str], None],
        acts: Callable[[int], None],
    ) -> None:
        self._runtime = runtime
        self._graph = runtime.graph
        self._interfaces = interfaces
        self._wire = wire_of(interfaces)
        self._relay = relay
        self._report = report
        self._senders = Senders(runtime, acts)
        self.sender: Callable[[str, bytes, int | None, int | None], tuple[Frame, ...]] = (
            self._senders.of
        )
        self._making = False
        self._ours: set[Publication] = set()
        self._publications: dict[tuple[str, str], Publication] = {}
        self._subscriptions: dict[tuple[str, str], Subscription] = {}
        self._advertised: set[str] = set()
        self._served: set[str] = set()
        self._heard: set[str] = set()
        self._own_services: set[str] = set()
        self._qualities: dict[str, dict[str, Any]] = {}
        self._types: dict[str, str] = {}
        self._silent: set[str] = set()
        tracer: Any = runtime.tracer
        tracer.on_behalf = self._senders.acting_now
        # Whoever comes gets the time at once, although the clock may stand still.
        self._advertise(CLOCK, _CLOCK_TYPE, latch=True)
        self._graph.watch(self._on_change)
        self.actions = ActionBridge(runtime, interfaces, relay, self._say_once)
        """What passes on the actions of ROS 2; in ROS 1 they are topics."""

    # What the controller's process sends

    def sent(self, header: dict[str, Any], body: bytes) -> None:
        """Note which functions sent a message, a request or a goal, known by its content."""
        of = header.get("digest") or self._digest(header, body)
        if of is not None:
            self._senders.sent(of, frames_of(header["stack"]), header["thread"])

    def _digest(self, header: dict[str, Any], body: bytes) -> str | None:
        """Return what stands for a message of ROS 2; None where the twin does not hear it."""
        name, kind, type_name = header["name"], header["kind"], header["type"]
        if kind == "message":
            if name not in self._heard:
                return None
            of = self._interfaces.message(type_name)
        elif kind == "call":
            if name not in self._served:
                return None
            of, _ = self._wire.parts(self._interfaces.service(type_name))
        else:
            of = self.actions.goal_class(name)
        return None if of is None else digest(self._content(body, of))

    def _content(self, body: bytes, kind: Any) -> bytes:
        return self._wire.content(body, self._wire.decode(body, kind))

    def service_client(self, name: str, type_name: str) -> None:
        """Note that the controller has a client of a service."""
        if name in self._own_services:
            return
        self._types[name] = type_name
        self._graph.services.become_caller(name, type_name)
        self._offer(name)

    def serves(self, name: str) -> None:
        """Note that the controller serves a name itself: the twin leaves it to it."""
        self._own_services.add(name)
        if name in self._served:
            self._served.discard(name)
            self._relay.send({"do": "close", "name": name})

    # What the relay sends, or in ROS 2 the controller, which has no master

    def take(self, header: dict[str, Any], body: bytes) -> None:
        """Take a frame of the relay."""
        what = header["is"]
        if what == "message":
            self._message(header, body)
        elif what in ("goal", "cancel"):
            self._goal(header, body)
        elif what == "publisher":
            self._qualities.setdefault(header["name"], header.get("quality", {}))
            self._publisher(header["name"], header["caller"], header["type"])
        elif what == "subscriber":
            self._subscriber(header)
        elif what == "no_publisher":
            self._leave(self._publications, header)
        elif what == "no_subscriber":
            self._leave(self._subscriptions, header)
        elif what == "lookup":
            self._offer(header["name"])
            self._relay.send({"do": "answer", "number": header["number"], "ok": True})
        elif what == "call":
            self._call(header["name"], header["number"], body)
        elif what == "parameter":
            self._graph.parameters.set(header["name"], header["value"])
        elif what == "lacks":
            self._lacks(header["name"], header["message"])

    @property
    def now_ns(self) -> int:
        """The time of ROS [ns]."""
        return EPOCH_NS + self._runtime.scheduler.now_ns

    def tick(self) -> None:
        """Publish the clock."""
        message: Any = self._interfaces.message(_CLOCK_TYPE)()
        set_time(message.clock, self.now_ns)
        self._relay.send({"do": "publish", "topic": CLOCK}, self._wire.encode(message))

    def listen(
        self, topic: str, type_name: str | None = None, quality: dict[str, Any] | None = None
    ) -> None:
        """Receive in real ROS what is published on a topic, in ROS 2 of a type and quality."""
        self._heard.add(topic)
        known = quality or self._qualities.get(topic, {})
        kind = type_name or self._types.get(topic)
        self._relay.send({"do": "subscribe", "topic": topic, "type": kind, **known})

    def give_parameters(self) -> None:
        """Set all parameters of the graph at the master, and what the twin offers besides."""
        parameters = self._graph.parameters
        for name in parameters.names():
            self._parameter(name, parameters.get(name))

    def _parameter(self, name: str, value: Any) -> None:
        if isinstance(value, str | int | float | bool | list):
            self._relay.send({"do": "parameter", "name": name, "value": value})

    # Topics

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if name in (CLOCK, *_OF_LOGGING):
            return
        if change == "advertised" and not self._making:
            for publication in self._graph.publications(name):
                if publication not in self._ours:
                    self._advertise(name, type_name, latch=publication.latch)
        elif change == "subscribed":
            self._listen(name)
        elif change == "served":
            self._offer(name)

    def _advertise(self, topic: str, type_name: str, *, latch: bool) -> None:
        if topic in self._advertised:
            return
        kind = self._class(topic, type_name)
        if kind is None:
            return
        self._advertised.add(topic)
        self._relay.send(
            {"do": "advertise", "topic": topic, "latch": latch, **self._wire.message(kind)}
        )

    def _publisher(self, topic: str, caller: str, type_name: str) -> None:
        if topic in _OF_LOGGING or self._class(topic, type_name) is None:
            return
        if self._wire.ros == 1 and topic.endswith(_TO_SERVERS) and self._is_own_server(topic):
            return
        self._making = True
        try:
            publication = self._graph.advertise(topic, type_name, node=caller)
        finally:
            self._making = False
        self._ours.add(publication)
        self._publications[topic, caller] = publication
        self._types[topic] = type_name
        # Servers of actions begin to publish by now.
        for name, kind in self._graph.published_topics():
            if any(item not in self._ours for item in self._graph.publications(name)):
                latch = any(item.latch for item in self._graph.publications(name))
                if name != CLOCK and name not in _OF_LOGGING:
                    self._advertise(name, kind, latch=latch)
        self._listen(topic)

    def _listen(self, topic: str) -> None:
        """Receive in real ROS what the controller publishes and the twin's side subscribes to."""
        if not any(name == topic for name, _ in self._publications):
            return
        theirs = set(self._subscriptions.values())
        if any(
            subscription not in theirs and not subscription.by_controller
            for subscription in self._graph.subscriptions(topic)
        ):
            self.listen(topic)

    def _subscriber(self, header: dict[str, Any]) -> None:
        topic, caller, type_name = header["name"], header["caller"], header["type"]
        if topic in (CLOCK, *_OF_LOGGING):
            return
        if type_name == ANY_TYPE:
            publications = self._graph.publications(topic)
            type_name = publications[0].type_name if publications else ANY_TYPE
        if type_name != ANY_TYPE and self._class(topic, type_name) is None:
            return
        self._subscriptions[topic, caller] = self._graph.subscribe(
            topic,
            type_name,
            lambda message, publication: self._forward(topic, message, publication),
            node=caller,
            takes_latched=header.get("takes_latched", True),
        )

    def _forward(self, topic: str, message: Any, publication: Publication) -> None:
        if publication in self._ours or self._relay.is_closed:
            return  # real ROS carries it from the one node to the other; or nobody hears any more
        self._advertise(topic, publication.type_name, latch=publication.latch)
        if topic in self._advertised:
            self._relay.send({"do": "publish", "topic": topic}, self._wire.encode(message))

    def _message(self, header: dict[str, Any], body: bytes) -> None:
        topic, number, at_ns = header["topic"], header.get("sequence"), header.get("at_ns")
        publication = self._publication(topic, header["caller"])
        if publication is None:
            self.sender(topic, body, number, at_ns)
            return
        kind: Any = self._interfaces.message(publication.type_name)
        message = self._wire.decode(body, kind)
        content = self._wire.content(body, message)
        number = self._wire.number(content, kind) if number is None else number
        stack = self.sender(topic, content, number, at_ns)
        with self._senders.acting(stack):
            publication.publish(message)

    def _publication(self, topic: str, caller: str) -> Publication | None:
        """Return the publication of a node; where the transport names none, one of the topic."""
        if caller:
            return self._publications.get((topic, caller))
        of_topic = (end for (name, _), end in self._publications.items() if name == topic)
        return next(of_topic, None)

    def _lacks(self, name: str, message: str) -> None:
        """Report what the installed ROS lacks, where the controller has to do with it."""
        ends = (*self._subscriptions, *self._publications)
        if name in self._types or any(topic == name for topic, _ in ends):
            self._say_once(name, f"{name} stays out of the twin: {message}")

    def _leave(self, ends: dict[tuple[str, str], Any], header: dict[str, Any]) -> None:
        end = ends.pop((header["name"], header["caller"]), None)
        if end is not None:
            end.close()

    def _is_own_server(self, topic: str) -> bool:
        """Return whether the controller serves the action of a topic itself."""
        return any(name == topic for name, _ in self._subscriptions)

    # Services

    def _offer(self, name: str) -> None:
        """Serve in real ROS what the graph serves under a name, if anything."""
        server = self._graph.services.find(name, self._types.get(name))
        if server is None or name in self._served or name in self._own_services:
            return
        try:
            kind: Any = self._interfaces.service(server.type_name)
        except InputError as error:
            self._say_once(name, f"service {name} is not served: {error.message}")
            return
        self._served.add(name)
        self._relay.send(
            {"do": "serve", "name": name, **self._wire.service(server.type_name, kind)}
        )

    def _call(self, name: str, number: int, body: bytes) -> None:
        server = self._graph.services.find(name, self._types.get(name))
        content = body
        if server is not None:
            asked, _ = self._wire.parts(self._interfaces.service(server.type_name))
            content = self._content(body, asked)
        stack = self.sender(name, content, None, None)

        def answer() -> None:
            server = self._graph.services.find(name, self._types.get(name))
            if server is None:
                self._failed(number, f"service {name} is served no longer")
                return
            kind, other_kind = self._wire.parts(self._interfaces.service(server.type_name))
            request = self._wire.decode(body, kind)
            try:
                with self._senders.acting(stack):
                    response = self._graph.services.call(server, request)
                answered = self._wire.encode(response if response is not None else other_kind())
            except Exception as error:  # noqa: BLE001 - passed on to who called, as rospy does
                self._failed(number, str(error))
                return
            self._relay.send({"do": "answer", "number": number, "ok": True}, answered)

        self._runtime.scheduler.spawn(
            answer, f"call of {name}", inherit=False, is_controllers=False
        )

    def _goal(self, header: dict[str, Any], body: bytes) -> None:
        kind = self.actions.goal_class(header["name"])
        stack: tuple[Frame, ...] = ()
        if header["is"] == "goal" and kind is not None:
            stack = self.sender(header["name"], self._content(body, kind), None, None)
        with self._senders.acting(stack):
            self.actions.take(header, body)

    def _failed(self, number: int, message: str) -> None:
        self._relay.send({"do": "answer", "number": number, "ok": False, "message": message})

    def _class(self, topic: str, type_name: str) -> Any:
        try:
            return self._interfaces.message(type_name)
        except InputError as error:
            self._say_once(topic, f"topic {topic} stays out of the twin: {error.message}")
            return None

    def _say_once(self, name: str, message: str) -> None:
        if name not in self._silent:
            self._silent.add(name)
            self._report(message)
