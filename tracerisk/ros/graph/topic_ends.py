"""The ends of a topic: who publishes on it, and who subscribes to it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.graph.graph_names import ANY_TYPE
from tracerisk.ros.time.publishing_pace import PublishingPace

if TYPE_CHECKING:
    from tracerisk.ros.graph.graph import Graph

SHOWN = re.compile(r"(visualization_msgs|rosgraph_msgs|rcl_interfaces)/|moveit_msgs/Display")
"""The types of messages that are only for display."""


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
        return tuple(
            subscription
            for subscription in self.matching()
            if self.graph.is_connected(self, subscription)
        )

    @property
    def is_wanted(self) -> bool:
        """Whether anybody subscribes to what it publishes, connected or not yet."""
        return bool(self.matching())

    def matching(self) -> list[Subscription]:
        """Return the subscriptions of its type, connected or not yet."""
        if self.closed:
            return []
        known = self.graph.subscriptions(self.topic)
        return [
            subscription
            for subscription in known
            if types_agree(self.type_name, subscription.type_name)
        ]

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
        late = (
            [subscription for subscription in self.matching() if subscription not in receivers]
            if only is None
            else []
        )
        if self.by_controller and only is None and (cell := self.graph.count(self.topic)):
            cell.published(self, (*receivers, *late), message)
        if self.by_controller and (late or receivers):
            self._note_lost(late, message)
        if not receivers:
            if not late and self.topic not in self.graph.first_unheard:
                self.graph.first_unheard[self.topic] = self, asking_place()
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
        elif not SHOWN.match(self.type_name):
            what, is_kept = f"a message on {self.topic}", self.latch or self.has_history
            carrier.note_early(what, self.topic, "publisher", message, is_kept=is_kept)

    def close(self) -> None:
        """Leave the topic."""
        if not self.closed:
            receivers = self.subscriptions
            self.closed = True
            self.graph.remove_publication(self, receivers)


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
            publication
            for publication in known
            if types_agree(publication.type_name, self.type_name)
            and self.graph.is_connected(publication, self)
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
            self.graph.remove_subscription(self, senders)
            for notify in self.on_close:
                notify()


def types_agree(published: str, subscribed: str) -> bool:
    """Return whether messages pass between ends of these types."""
    return published == subscribed or ANY_TYPE in (published, subscribed)
