"""The graph in one process: topics, services and parameters that nodes and the twin share.

A topic connects every publication and subscription of its name whose types agree. What is
published reaches each subscription as one call of its `deliver`, in the order in which they
subscribed; whether that runs a callback on a thread of its own (ROS 1) or waits in a queue until
something spins (ROS 2) is the client library's affair. Actions are topics and services.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol

from tracerisk.common.worlds.world import NOMINAL, World
from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need, asking_place
from tracerisk.ros.graph.parameters import ParameterTree
from tracerisk.ros.graph.services import Services, ServiceServer
from tracerisk.ros.graph.topic_ends import SHOWN, Publication, Subscription, types_agree
from tracerisk.ros.time.scheduler import CallTracer, Scheduler
from tracerisk.ros.world.carrier import Carrier
from tracerisk.ros.world.connecting import ConnectionTimes, EndKind

if TYPE_CHECKING:
    from tracerisk.ros.controller.node_process import NodeProcess
    from tracerisk.ros.graph.action_goal import ActionGoal


_FIRST_NS = 1_000_000_000  # what comes once a second has come to a node of the bring-up [ns]

Change = Literal["advertised", "unadvertised", "subscribed", "unsubscribed", "served", "unserved"]


def _report_on_stderr(message: str) -> None:
    sys.stderr.write(f"[ERROR] {message}\n")


@dataclass(slots=True, eq=False)
class _Topic:
    """The ends of one topic."""

    publications: list[Publication] = field(default_factory=list)
    """The publications, in the order in which they were made."""
    subscriptions: list[Subscription] = field(default_factory=list)
    """The subscriptions, in the order in which they were made."""


class CellWatch(Protocol):
    """What is notified of what the controller sends to anything but itself."""

    def published(
        self, publication: Publication, receivers: Sequence[Subscription], message: Any
    ) -> None:
        """Note a message and who receives it."""

    def called(self, server: ServiceServer, request: Any) -> Callable[[Any], None] | None:
        """Note a call; return what wants its response, or None where it fails."""

    def sent(self, goal: ActionGoal) -> None:
        """Note a goal."""


class Graph:
    """Topics, services and parameters of one run.

    `tracer` makes each service handler a root. `warn` gets what a user should know, such as
    two types on one topic; by default it is an error line on standard error.
    `world` says how long messages take, and how long ends take to connect; where it leaves that
    open `times` do.
    `counts` is how many messages, calls and goals of the controller went to each name, without
    those of nodes started beside it; `cell` is notified of each.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        tracer: CallTracer | None = None,
        *,
        warn: Callable[[str], None] = _report_on_stderr,
        world: World = NOMINAL,
        times: ConnectionTimes | None = None,
    ) -> None:
        self.scheduler = scheduler
        self.tracer = tracer
        self.carrier = Carrier(scheduler, tracer, world, times)
        self.parameters = ParameterTree()
        self.services = Services(self)
        self._warn = warn
        self._topics: dict[str, _Topic] = {}
        self.counts: Counter[str] = Counter()
        self.cell: CellWatch | None = None
        self._answers: dict[str, list[Callable[[], None]]] = {}
        self._warm: set[NodeProcess] = set()
        self.first_unheard: dict[str, tuple[Publication, Location | None]] = {}
        """Who first published on a topic to which nobody subscribed, and where."""
        self._watchers: list[Callable[[Change, str, str], None]] = []
        scheduler.listens = self.listens

    def count(self, name: str) -> CellWatch | None:
        """Count a message, call or goal to a name; return who is to be notified of it, if anybody.

        What a node started beside the controller sends is not counted.
        """
        if self.scheduler.process is not None:
            return None
        self.counts[name] += 1
        for answer in self._answers.get(name, ()):
            answer()
        return self.cell

    def when_sent(self, name: str, answer: Callable[[], None]) -> None:
        """Call `answer` whenever the controller sends a message, call or goal to a name."""
        self._answers.setdefault(name, []).append(answer)

    def listens(self) -> bool:
        """Return whether the controller subscribes or serves: the world outside could wake it."""
        return any(server.is_callback for server in self.services) or any(
            subscription.by_controller
            for topic in self._topics.values()
            for subscription in topic.subscriptions
        )

    def watch(self, watcher: Callable[[Change, str, str], None]) -> None:
        """Call `watcher` with change, name and type whenever an endpoint comes or goes.

        So the twin finds the interfaces that a controller talks to by their type.
        It is called at once with all that exist already.
        """
        self._watchers.append(watcher)
        for name, topic in list(self._topics.items()):
            for publication in topic.publications:
                watcher("advertised", name, publication.type_name)
            for subscription in topic.subscriptions:
                watcher("subscribed", name, subscription.type_name)
        for server in tuple(self.services):
            watcher("served", server.name, server.type_name)

    # Topics

    def advertise(
        self,
        topic: str,
        type_name: str,
        *,
        node: str,
        latch: bool = False,
        copy: Callable[[Any], Any] = lambda message: message,
        on_connect: Callable[[Subscription], None] | None = None,
        on_disconnect: Callable[[Subscription], None] | None = None,
        by_controller: bool = True,
    ) -> Publication:
        """Begin to publish on a topic; those who subscribed already are connected.

        `by_controller` is False for a scenario's and the twin's: what these publish commands
        nothing.
        """
        bound = self.scheduler.bound
        if on_connect is not None:
            on_connect = bound(on_connect)
        if on_disconnect is not None:
            on_disconnect = bound(on_disconnect)
        publication = Publication(
            self, topic, type_name, node, latch, copy, on_connect, on_disconnect, by_controller
        )
        publication.made_ns = self.carrier.made_ns(by_controller=by_controller)
        publication.process = self.scheduler.process if by_controller else None
        entry = self._topics.setdefault(topic, _Topic())
        for other in entry.subscriptions:
            self._warn_of_types(topic, type_name, other.type_name)
        entry.publications.append(publication)
        known = publication.matching()  # who subscribes because of the report connects by itself
        self.report("advertised", topic, type_name)
        for subscription in known:
            self._connect(publication, subscription)
        return publication

    def subscribe(
        self,
        topic: str,
        type_name: str,
        deliver: Callable[[Any, Publication], None],
        *,
        node: str,
        on_disconnect: Callable[[Publication], None] | None = None,
        by_controller: bool = True,
        takes_latched: bool = True,
    ) -> Subscription:
        """Begin to receive from a topic; if it `takes_latched`, what is latched comes at once.

        `by_controller` is False for the twin's own: they make no controller listen.
        """
        place = asking_place() if by_controller else None
        if by_controller:
            deliver = self.scheduler.bound(deliver, asks=True)
        if on_disconnect is not None:
            on_disconnect = self.scheduler.bound(on_disconnect)
        subscription = Subscription(
            self, topic, type_name, node, deliver, on_disconnect, by_controller, place
        )
        subscription.takes_latched = takes_latched
        entry = self._topics.setdefault(topic, _Topic())
        for other in entry.publications:
            self._warn_of_types(topic, other.type_name, type_name)
        entry.subscriptions.append(subscription)
        subscription.made_ns = self.carrier.made_ns(by_controller=by_controller)
        subscription.process = self.scheduler.process if by_controller else None
        known = self.publications(topic)
        self.report("subscribed", topic, type_name)
        for publication in known:
            if types_agree(publication.type_name, type_name):
                self._connect(publication, subscription)
        return subscription

    def is_connected(self, publication: Publication, subscription: Subscription) -> bool:
        """Return whether two ends of a topic have found each other."""
        return self._connected_ns(publication, subscription) <= self.scheduler.now_ns

    def when_connected(
        self, publication: Publication, subscription: Subscription, act: Callable[[], None]
    ) -> None:
        """Call `act` once two ends of a topic have found each other, now where they have."""
        due_ns = self._connected_ns(publication, subscription)
        self.carrier.expect(due_ns)
        if due_ns <= self.scheduler.now_ns:
            act()
        else:
            self.scheduler.call_at(due_ns, act)

    def _connected_ns(self, publication: Publication, subscription: Subscription) -> int:
        made_ns = max(publication.made_ns, subscription.made_ns)
        if publication.by_controller != subscription.by_controller:
            kind: EndKind = "publisher" if publication.by_controller else "subscriber"
            return self.carrier.connected_ns(publication.topic, made_ns, kind)
        if not publication.by_controller:
            return 0  # of the cell, which was there before
        is_within = publication.process is subscription.process
        return self.carrier.own_connected_ns(made_ns, "subscriber", is_within=is_within)

    def _connect(self, publication: Publication, subscription: Subscription) -> None:
        def connect() -> None:
            if publication.closed or subscription.closed:
                return
            if publication.on_connect is not None:
                publication.on_connect(subscription)
            if publication.by_controller and (publication.latch or publication.has_history):
                self.carrier.note_delivered(publication.topic)
            if publication.latched is None:
                return
            if subscription.takes_latched:
                subscription.receive(publication.latched, publication)
            else:
                subscription.has_missed_latched = True

        self.when_connected(publication, subscription, connect)

    def publications(self, topic: str) -> tuple[Publication, ...]:
        """Return who publishes on a topic."""
        return tuple(self._topics[topic].publications) if topic in self._topics else ()

    def subscriptions(self, topic: str) -> tuple[Subscription, ...]:
        """Return who subscribes to a topic."""
        return tuple(self._topics[topic].subscriptions) if topic in self._topics else ()

    def await_first_messages(self, process: NodeProcess | None) -> None:
        """Wait until a companion that is called for the first time knows the robot's state.

        A bring-up starts it before the controller: by then, a message has come on each topic that
        the twin publishes. What comes more seldom than `_FIRST_NS` it may lack.
        """
        if process is None or process in self._warm or process is self.scheduler.process:
            return
        self._warm.add(process)
        heard = [
            subscription
            for topic in self._topics.values()
            for subscription in topic.subscriptions
            if subscription.process is process
            and any(not sender.by_controller for sender in topic.publications)
        ]
        if heard:
            self.scheduler.wait_until(
                lambda: all(one.has_received or one.closed for one in heard),
                timeout_ns=_FIRST_NS,
                reason=f"the first messages of {process.name}",
            )

    def unpublished(self) -> tuple[Missed, ...]:
        """Return the topics that the controller subscribes to and nobody publishes."""
        return tuple(
            Missed(
                Need("topic", subscription.topic, subscription.type_name), 0, 0, subscription.place
            )
            for topic in self._topics.values()
            for subscription in topic.subscriptions
            if subscription.by_controller
            and subscription.place is not None
            and not subscription.publications
        )

    def too_late(self) -> tuple[Missed, ...]:
        """Return the topics from which the controller gets nothing: it asks for no old message."""
        return tuple(
            Missed(
                Need("topic", subscription.topic, subscription.type_name), 0, 0, subscription.place
            )
            for topic in self._topics.values()
            for subscription in topic.subscriptions
            if subscription.by_controller
            and subscription.place is not None
            and subscription.has_missed_latched
        )

    def unheard(self) -> tuple[Missed, ...]:
        """Return the topics on which the controller has published and nobody subscribes.

        Topics that are only for display are left out.
        """
        return tuple(
            Missed(Need("topic", name, publication.type_name), 0, 0, place)
            for name, (publication, place) in self.first_unheard.items()
            if publication.by_controller and not self.subscriptions(name)
            if not SHOWN.match(publication.type_name)
        )

    def topic_names(self) -> tuple[str, ...]:
        """Return the names of all topics that anybody has used, sorted."""
        return tuple(sorted(self._topics))

    def published_topics(self) -> tuple[tuple[str, str], ...]:
        """Return name and type of each topic that somebody publishes, sorted."""
        return tuple(
            (name, entry.publications[0].type_name)
            for name, entry in sorted(self._topics.items())
            if entry.publications
        )

    def heard_topics(self) -> frozenset[tuple[str, str]]:
        """Return name and type of each topic that the controller subscribes to."""
        return frozenset(
            (name, subscription.type_name)
            for name, entry in self._topics.items()
            for subscription in entry.subscriptions
            if subscription.by_controller
        )

    # Endpoints come and go

    def remove_publication(
        self, publication: Publication, receivers: tuple[Subscription, ...]
    ) -> None:
        """Take a publication away, and notify those that it reached."""
        self._topics[publication.topic].publications.remove(publication)
        for receiver in receivers:
            if receiver.on_disconnect is not None:
                receiver.on_disconnect(publication)
        self.report("unadvertised", publication.topic, publication.type_name)

    def remove_subscription(
        self, subscription: Subscription, senders: tuple[Publication, ...]
    ) -> None:
        """Take a subscription away, and notify those that reached it."""
        self._topics[subscription.topic].subscriptions.remove(subscription)
        for sender in senders:
            if sender.on_disconnect is not None:
                sender.on_disconnect(subscription)
        self.report("unsubscribed", subscription.topic, subscription.type_name)

    def report(self, change: Change, name: str, type_name: str) -> None:
        """Notify all watchers that an endpoint comes or goes."""
        for watcher in tuple(self._watchers):
            watcher(change, name, type_name)

    def _warn_of_types(self, topic: str, published: str, subscribed: str) -> None:
        if not types_agree(published, subscribed):
            self._warn(
                f"topic {topic} is published as {published} and subscribed to as {subscribed}: "
                f"no message passes between the two"
            )
