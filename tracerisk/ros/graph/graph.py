"""The graph in one process: topics, services and parameters that nodes and the twin share.

A topic connects every publication and subscription of its name whose types agree. What is
published reaches each subscription as one call of its `deliver`, in the order in which they
subscribed; whether that runs a callback on a thread of its own (ROS 1) or waits in a queue until
something spins (ROS 2) is the client library's affair. Actions are topics and services.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, Protocol

from tracerisk.common.worlds.world import NOMINAL, World
from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need, asking_place
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.graph.graph_names import ANY_TYPE
from tracerisk.ros.graph.parameters import ParameterTree
from tracerisk.ros.time.publishing_pace import PublishingPace
from tracerisk.ros.time.scheduler import CallTracer, Scheduler
from tracerisk.ros.world.carrier import Carrier
from tracerisk.ros.world.connecting import ConnectionTimes, EndKind

if TYPE_CHECKING:
    from tracerisk.ros.graph.action_goal import ActionGoal

# Served by a library in the controller, for tools: buffers of tf2, servers of parameters, what
# state a lifecycle node is in.
_OF_TOOLS = re.compile(
    r"tf2_msgs/FrameGraph$|dynamic_reconfigure/|rcl_interfaces/|roscpp/|lifecycle_msgs/Get"
)
_FIRST_NS = 1_000_000_000  # what comes once a second has come to a node of the bring-up [ns]
_SHOWN = re.compile(r"(visualization_msgs|rosgraph_msgs|rcl_interfaces)/|moveit_msgs/Display")

_Finder = Callable[[str], tuple[str, Callable[[Any], Any], str] | None]
Change = Literal["advertised", "unadvertised", "subscribed", "unsubscribed", "served", "unserved"]


def _report_on_stderr(message: str) -> None:
    sys.stderr.write(f"[ERROR] {message}\n")


@dataclass(slots=True, eq=False)
class Publication:
    """A node's right to publish on a topic."""

    graph: Graph
    """The graph of the run."""
    topic: str
    """The full name of the topic."""
    type_name: str
    """The type of its messages, `package/Name`."""
    node: str
    """The full name of the node."""
    latch: bool
    """Whether the last message is kept for later subscriptions."""
    copy: Callable[[Any], Any]
    """The function that makes the message to send from a given one."""
    on_connect: Callable[[Subscription], None] | None = None
    """The function for each subscription that connects; `None`: none."""
    on_disconnect: Callable[[Subscription], None] | None = None
    """The function for each subscription that leaves; `None`: none."""
    by_controller: bool = True
    """Whether the controller's code publishes; False for the twin and a scenario."""
    latched: Any = None
    """The last message, where it is kept; else `None`."""
    sent: int = 0
    """The number of messages that were sent."""
    closed: bool = False
    """Whether it has left the topic."""
    on_received: Callable[[Subscription], None] | None = None
    """The function for each controller subscription that receives a message; `None`: none."""
    pace: PublishingPace = field(default_factory=PublishingPace)
    """The pacing of a thread that publishes without ever waiting."""
    made_ns: int = 0
    """The simulated time at which it was made [ns]."""
    process: NodeProcess | None = None
    """The node beside the controller that it belongs to; `None` for the controller's own."""
    keeps_for_late: bool = False
    """Whether a message waits for subscriptions that exist and are not connected yet."""
    has_history: bool = False
    """Whether its library sends what it sent before to who connects later: transient local."""

    @property
    def subscriptions(self) -> tuple[Subscription, ...]:
        """The subscriptions that it reaches, in the order in which they were made."""
        return tuple(each for each in self._matching() if self.graph.is_connected(self, each))

    @property
    def is_wanted(self) -> bool:
        """Whether anybody subscribes to what it publishes, connected or not yet."""
        return bool(self._matching())

    def _matching(self) -> list[Subscription]:
        if self.closed:
            return []
        known = self.graph.subscriptions(self.topic)
        return [each for each in known if _types_agree(self.type_name, each.type_name)]

    def publish(self, message: Any, only: Subscription | None = None) -> None:
        """Send a copy of `message` to every subscription, or to one; keep it where it is latched.

        Raises:
            RunOver: the run is over.
        """
        scheduler = self.graph.scheduler
        scheduler.count_call()
        scheduler.raise_if_over()
        self.pace.keep(scheduler)
        receivers = self.subscriptions if only is None else (only,)
        late = [each for each in self._matching() if each not in receivers] if only is None else []
        if self.by_controller and only is None and (cell := self.graph.count(self.topic)):
            cell.published(self, (*receivers, *late), message)
        if self.by_controller and (late or receivers):
            self._note_lost(late, message)
        if not receivers:
            if not late and self.topic not in self.graph._unheard:
                self.graph._unheard[self.topic] = self, asking_place()
            if not self.latch and not self.keeps_for_late:
                return
        snapshot = self.copy(message)
        self.sent += 1
        if self.latch and only is None:
            self.latched = snapshot
        for receiver in receivers:
            self.graph.carrier.carry(
                partial(receiver.receive, snapshot, self),
                self.topic,
                (id(self), id(receiver)),
                is_away=self.by_controller != receiver.by_controller,
            )
        if self.keeps_for_late:
            for receiver in late:
                self.graph.when_connected(self, receiver, partial(receiver.receive, snapshot, self))

    def _note_lost(self, late: Sequence[Subscription], message: Any) -> None:
        """Note whether a message of the controller's reaches all that it should."""
        carrier = self.graph.carrier
        if not late:
            carrier.note_in_time(self.topic, message)
        elif not _SHOWN.match(self.type_name):
            what, is_kept = f"a message on {self.topic}", self.latch or self.has_history
            carrier.note_early(what, self.topic, "publisher", message, is_kept=is_kept)

    def close(self) -> None:
        """Leave the topic."""
        if not self.closed:
            receivers = self.subscriptions
            self.closed = True
            self.graph._remove_publication(self, receivers)


@dataclass(slots=True, eq=False)
class Subscription:
    """A receiver of a topic's messages."""

    graph: Graph
    """The graph of the run."""
    topic: str
    """The full name of the topic."""
    type_name: str
    """The type of its messages, `package/Name`, or `*` for any."""
    node: str
    """The full name of the node."""
    deliver: Callable[[Any, Publication], None]
    """The function for each message and its publication, called while it is published; it must
    neither wait nor change the message, which others receive too."""
    on_disconnect: Callable[[Publication], None] | None = None
    """The function for each publication that leaves; `None`: none."""
    by_controller: bool = True
    """Whether the controller's code subscribes; False for the twin."""
    place: Location | None = None
    """The line of the controller that made it; `None` where none is known."""
    hears_scenario: bool = False
    """Whether a subscription of the twin takes what a scenario sends."""
    closed: bool = False
    """Whether it has left the topic."""
    process: NodeProcess | None = None
    """The node beside the controller that it belongs to; `None` for the controller's own."""
    takes_latched: bool = True
    """Whether it gets what was latched before it came; in ROS 2 only if it is transient local."""
    has_missed_latched: bool = False
    """Whether something was latched before it came, and it has received nothing at all."""
    on_close: list[Callable[[], None]] = field(default_factory=list)
    """The functions to call when it leaves its topic."""
    made_ns: int = 0
    """The simulated time at which it was made [ns]."""
    is_assumed: bool = False
    """Whether it stands for an assumed listener, for which the controller waits."""
    has_received: bool = False
    """Whether a message has come."""

    @property
    def publications(self) -> tuple[Publication, ...]:
        """The publications that reach it, in the order in which they were made."""
        if self.closed:
            return ()
        known = self.graph.publications(self.topic)
        return tuple(
            each
            for each in known
            if _types_agree(each.type_name, self.type_name) and self.graph.is_connected(each, self)
        )

    def receive(self, message: Any, publication: Publication) -> None:
        """Take a message of a publication; one that comes after its end is dropped."""
        if self.closed:
            return
        if publication.on_received is not None and self.by_controller:
            publication.on_received(self)
        self.has_missed_latched = False
        self.has_received = True
        self.deliver(message, publication)

    def close(self) -> None:
        """Leave the topic."""
        if not self.closed:
            senders = self.publications
            self.closed = True
            self.graph._remove_subscription(self, senders)
            for notify in self.on_close:
                notify()


@dataclass(slots=True, eq=False)
class ServiceServer:
    """The server of a service."""

    graph: Graph
    """The graph of the run."""
    name: str
    """The full name of the service."""
    type_name: str
    """The type of the service, `package/Name`."""
    node: str
    """The full name of the node that serves it."""
    handle: Callable[[Any], Any]
    """The function that takes a request and returns the response."""
    is_callback: bool
    """Whether the handler is the controller's, and runs on a thread of its own."""
    place: Location | None = None
    """The line of the controller that made it; `None` where it is not the controller's."""
    is_called: bool = False
    """Whether it was ever called."""
    process: NodeProcess | None = None
    """The node beside the controller that it belongs to; `None` for all others."""
    made_ns: int = 0
    """The simulated time at which it was made [ns]."""
    is_scenario: bool = False
    """Whether a scenario plays it."""

    def close(self) -> None:
        """Stop serving; calls that run go on."""
        self.graph._remove_service(self)


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


class ServiceFailedError(Exception):
    """A handler could not answer; raised in the caller with what the handler says."""


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
        self._warn = warn
        self._topics: dict[str, _Topic] = {}
        self.counts: Counter[str] = Counter()
        self.cell: CellWatch | None = None
        self._warm: set[NodeProcess] = set()
        self._unheard: dict[str, tuple[Publication, Location | None]] = {}
        self._services: dict[str, ServiceServer] = {}
        self._callers: dict[Need, Missed] = {}
        self._sought_ns: dict[str, int] = {}
        self._offers: dict[str, dict[str, tuple[Callable[[Any], Any], str]]] = {}
        self._finders: list[_Finder] = []
        self._watchers: list[Callable[[Change, str, str], None]] = []
        scheduler.listens = self.listens

    def count(self, name: str) -> CellWatch | None:
        """Count a message, call or goal to a name; return who is to be notified of it, if anybody.

        What a node started beside the controller sends is not counted.
        """
        if self.scheduler.process is not None:
            return None
        self.counts[name] += 1
        return self.cell

    def listens(self) -> bool:
        """Return whether the controller subscribes or serves: the world outside could wake it."""
        return any(server.is_callback for server in self._services.values()) or any(
            each.by_controller for topic in self._topics.values() for each in topic.subscriptions
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
        for server in list(self._services.values()):
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
        self._report("advertised", topic, type_name)
        for subscription in publication._matching():
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
        self._report("subscribed", topic, type_name)
        for publication in self.publications(topic):
            if _types_agree(publication.type_name, type_name):
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

    def unpublished(self) -> tuple[Missed, ...]:
        """Return the topics that the controller subscribes to and nobody publishes."""
        return tuple(
            Missed(Need("topic", each.topic, each.type_name), 0, 0, each.place)
            for topic in self._topics.values()
            for each in topic.subscriptions
            if each.by_controller and each.place is not None and not each.publications
        )

    def too_late(self) -> tuple[Missed, ...]:
        """Return the topics from which the controller gets nothing: it asks for no old message."""
        return tuple(
            Missed(Need("topic", each.topic, each.type_name), 0, 0, each.place)
            for topic in self._topics.values()
            for each in topic.subscriptions
            if each.by_controller and each.place is not None and each.has_missed_latched
        )

    def unheard(self) -> tuple[Missed, ...]:
        """Return the topics on which the controller has published and nobody subscribes.

        Topics that are only for display are left out.
        """
        return tuple(
            Missed(Need("topic", name, each.type_name), 0, 0, place)
            for name, (each, place) in self._unheard.items()
            if each.by_controller and not self.subscriptions(name)
            if not _SHOWN.match(each.type_name)
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

    # Services

    def serve(
        self,
        name: str,
        type_name: str,
        handle: Callable[[Any], Any],
        *,
        node: str,
        is_callback: bool = True,
        is_scenario: bool = False,
    ) -> ServiceServer:
        """Answer calls of a service; a later server of the name takes the place of the first.

        With `is_callback` the handler runs as a root on a thread of its own; without, on the
        caller's thread: the twin's services.
        """
        place = asking_place() if is_callback else None
        server = ServiceServer(self, name, type_name, node, handle, is_callback, place)
        server.process = self.scheduler.process if is_callback else None
        server.made_ns = self.carrier.made_ns(by_controller=is_callback)
        server.is_scenario = is_scenario
        self._services[name] = server
        self._report("served", name, type_name)
        return server

    def offer(
        self, base_name: str, type_name: str, handle: Callable[[Any], Any], *, node: str
    ) -> None:
        """Serve `base_name` in whatever namespace somebody asks for it: a service of the twin's.

        A name that many use comes with the part before it: `motion/move_stop`.
        It begins when it is first asked for by name, and where nobody else serves that name.
        Who offers a name and type first serves it. Where several types are offered under one name,
        whoever asks says which is meant.
        """
        self._offers.setdefault(base_name, {}).setdefault(type_name, (handle, node))

    def offer_found(self, finder: _Finder) -> None:
        """Serve what `finder` returns for a name that nobody serves or offers.

        It returns type, handler and node, or None for a name that is none of its own.
        """
        self._finders.append(finder)

    def service(self, name: str, type_name: str | None = None) -> ServiceServer | None:
        """Return who serves a name, if anybody; a service of the twin's begins with that.

        One of another type than whoever asks means does not: many drivers have a `get_state`.
        One of the cell's that the controller is not connected to yet does not either.
        """
        server = self._server(name, type_name)
        return server if server is not None and self._is_found(server) else None

    def _is_found(self, server: ServiceServer) -> bool:
        """Return whether the controller has found a server of the cell."""
        if server.is_callback and server.process is self.scheduler.process:
            return True
        return self._found_ns(server) <= self.scheduler.now_ns

    def _found_ns(self, server: ServiceServer) -> int:
        """Return when the controller finds a server of the cell, or of a companion [ns]."""
        if server.is_callback:
            made_ns = max(server.made_ns, self._sought_ns.get(server.name, 0))
            return self.carrier.own_connected_ns(made_ns, "service client")
        if server.name in self._sought_ns:
            sought_ns = self._sought_ns[server.name]
            return self.carrier.connected_ns(server.name, sought_ns, "service client")
        # The master knows all that a node serves once that has started.
        return self.carrier.connected_ns(server.node, 0, "service client")

    def _wake_when_found(self, name: str, type_name: str | None) -> None:
        """Wake whoever waits for a service when the controller finds its server."""
        server = self._server(name, type_name)
        if server is not None and not self._is_found(server):
            self.carrier.expect(self._found_ns(server))
            self.scheduler.call_at(self._found_ns(server), lambda: None)

    def _server(self, name: str, type_name: str | None) -> ServiceServer | None:
        known = self._services.get(name)
        parts = name.rsplit("/", 2)
        offered = {
            **self._offers.get("/".join(parts[-2:]), {}),
            **self._offers.get(parts[-1], {}),
        }
        if known is None and offered and (type_name is None or type_name in offered):
            kind = next(iter(offered)) if type_name is None else type_name
        elif (
            known is not None
            and not known.is_callback
            and known.type_name in offered
            and type_name in offered
            and type_name != known.type_name
        ):
            # Waited for by its name alone, another vendor's was taken for it.
            kind = type_name
        else:
            return self._served_if_found(name) if known is None else known
        handle, node = offered[kind]
        return self.serve(name, kind, handle, node=node, is_callback=False)

    def _served_if_found(self, name: str) -> ServiceServer | None:
        found = next(filter(None, (finder(name) for finder in self._finders)), None)
        if found is None:
            return None
        kind, handle, node = found
        return self.serve(name, kind, handle, node=node, is_callback=False)

    def become_caller(self, name: str, type_name: str, *, connects: bool = False) -> None:
        """Note that the code which runs has a client of a service.

        One that `connects` (ROS 2) has to find the server first; else the master knows it, as soon
        as the cell has started.
        """
        if connects:
            self._sought_ns.setdefault(name, self.carrier.made_ns(by_controller=True))
        self._wake_when_found(name, type_name)
        need = Need("service", name, type_name)
        self._callers.setdefault(need, Missed(need, 0, 0, asking_place()))

    def unserved(self) -> tuple[Missed, ...]:
        """Return the services of which the controller has a client and that nobody serves."""
        return tuple(
            each
            for need, each in self._callers.items()
            if each.location is not None and self._server(need.name, need.type_name) is None
        )

    def uncalled(self) -> tuple[Missed, ...]:
        """Return the controller's own services that nobody has called, not those of companions."""
        return tuple(
            Missed(Need("call", each.name, each.type_name), 0, 0, each.place)
            for each in self._services.values()
            if each.is_callback
            and each.process is None
            and not each.is_called
            and not _OF_TOOLS.match(each.type_name)
        )

    def services(self) -> tuple[ServiceServer, ...]:
        """Return all servers, sorted by name."""
        return tuple(server for _, server in sorted(self._services.items()))

    def wait_for_service(
        self,
        name: str,
        *,
        type_name: str | None = None,
        timeout_ns: int | None = None,
        unless: Callable[[], bool] = lambda: False,
    ) -> bool:
        """Wait until a service is served, and return whether it is.

        False after the timeout, or as soon as `unless` holds.

        Raises:
            RunOver: the run is over; a wait that nothing can end is a deadlock that names the
                service and where the controller waits.
        """
        self._wake_when_found(name, type_name)
        text = f"service {name}" + (f" ({type_name})" if type_name else "")
        self.scheduler.wait_until(
            lambda: self._is_known(name) or unless(),
            timeout_ns=timeout_ns,
            reason=text,
            kind="unmet",
            need=Need("service", name, type_name or ""),
        )
        if not self._is_known(name):
            self.miss_service(name, type_name or "")
        return self._is_known(name)

    def miss_service(self, name: str, type_name: str, request: Any = None) -> None:
        """Note that the controller asks for a server that is not there, or not found yet."""
        need = Need("service", name, type_name)
        if self._server(name, type_name or None) is None:
            self.scheduler.miss(need)
            return
        self.scheduler.needs.meet(need)
        what = f"a question for service {name}" if request is None else f"a call of {name}"
        self.carrier.note_early(what, name, "service client", request)

    def find_service(self, name: str, type_name: str, request: Any = None) -> None:
        """Note that the controller has found a server that it asks for."""
        self.scheduler.needs.meet(Need("service", name, type_name))
        self.carrier.note_in_time(name, request)

    def _is_known(self, name: str) -> bool:
        known = self._services.get(name)
        return known is not None and self._is_found(known)

    def call(self, server: ServiceServer, request: Any) -> Any:
        """Call a service and wait for its response.

        Raises:
            RunOver: the run is over.
            BaseException: what the handler raised.
        """
        self.scheduler.raise_if_over()
        server.is_called = True
        cell = self.count(server.name)
        answered = None if cell is None else cell.called(server, request)
        try:
            response = self._answer(server, request)
        except BaseException:
            if answered is not None:
                answered(None)
            raise
        if answered is not None:
            answered(response)
        return response

    def _answer(self, server: ServiceServer, request: Any) -> Any:
        if not server.is_callback:
            self.carrier.pass_latency(server.name)
            response = server.handle(request)
            self.carrier.pass_latency(server.name)
            return response
        self.scheduler.ask(server.process)
        self._await_first_messages(server.process)
        answer = _Answer()
        thread = self.scheduler.spawn(
            lambda: self._handle(server, request, answer),
            f"service {server.name}",
            inherit=False,
            is_controllers=False,
            process=server.process,
        )
        self.scheduler.wait_until(
            lambda: thread.finished, reason=f"the response of service {server.name}", on=thread
        )
        if answer.error is not None:
            raise answer.error
        return answer.response

    def _await_first_messages(self, process: NodeProcess | None) -> None:
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

    def _handle(self, server: ServiceServer, request: Any, answer: _Answer) -> None:
        root = self.tracer.root("service") if self.tracer is not None else nullcontext()
        try:
            with root:
                answer.response = server.handle(request)
        except Exception as error:  # noqa: BLE001 - the handler's; raised again in its caller
            answer.error = error

    # Endpoints come and go

    def _remove_publication(
        self, publication: Publication, receivers: tuple[Subscription, ...]
    ) -> None:
        self._topics[publication.topic].publications.remove(publication)
        for receiver in receivers:
            if receiver.on_disconnect is not None:
                receiver.on_disconnect(publication)
        self._report("unadvertised", publication.topic, publication.type_name)

    def _remove_subscription(
        self, subscription: Subscription, senders: tuple[Publication, ...]
    ) -> None:
        self._topics[subscription.topic].subscriptions.remove(subscription)
        for sender in senders:
            if sender.on_disconnect is not None:
                sender.on_disconnect(subscription)
        self._report("unsubscribed", subscription.topic, subscription.type_name)

    def _remove_service(self, server: ServiceServer) -> None:
        if self._services.get(server.name) is server:
            del self._services[server.name]
            self._report("unserved", server.name, server.type_name)

    def _report(self, change: Change, name: str, type_name: str) -> None:
        for watcher in tuple(self._watchers):
            watcher(change, name, type_name)

    def _warn_of_types(self, topic: str, published: str, subscribed: str) -> None:
        if not _types_agree(published, subscribed):
            self._warn(
                f"topic {topic} is published as {published} and subscribed to as {subscribed}: "
                f"no message passes between the two"
            )


@dataclass(slots=True)
class _Answer:
    """The outcome of a service call."""

    response: Any = None
    """The response; `None` before there is one."""
    error: Exception | None = None
    """Why the handler could not answer; `None` where it did."""


def _types_agree(published: str, subscribed: str) -> bool:
    return published == subscribed or ANY_TYPE in (published, subscribed)
