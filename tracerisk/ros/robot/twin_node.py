"""A node of the twin on the graph: what it offers, what it hears and what it reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.messages import TwinMessages

if TYPE_CHECKING:
    from tracerisk.common.traced.elements import SensorKind
    from tracerisk.ros.graph.graph import Change
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.ros.graph.topic_ends import Publication
    from tracerisk.twin.simulation.twin import Twin

JOINTS: tuple[SensorKind, ...] = ("encoder", "torque")
"""The sensors that joint states are read of."""


class TwinNode:
    """What the nodes of robots' drivers share; each class says its `node`."""

    node = "/robot_driver"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        self._runtime = runtime
        self._twin: Twin = runtime.twin
        self._graph, self._scheduler = runtime.graph, runtime.scheduler
        self._messages = messages
        self._commands = runtime.client(TwinCommands)
        self._reading = runtime.client(SensorReading)
        self._heard: set[str] = set()
        self._reported: set[str] = set()

    def _key(self, name: str, type_name: str) -> str:
        """Return what is served once of a topic: it, whatever its type."""
        del type_name
        return name

    # Services and parameters

    def _offer(self, base_name: str, kind: str, handle: Callable[[Any, Any], Any]) -> None:
        """Serve a name in any namespace; `handle` takes the request and the answer that it fills.

        What the controller's ROS has no type of cannot be asked for.
        """
        if self._messages.has("service", kind):
            answer = partial(self._answer_to, kind, handle)
            self._graph.services.offer(base_name, kind, answer, node=self.node)

    def _answer_to(self, kind: str, handle: Callable[[Any, Any], Any], request: Any) -> Any:
        answer = self._messages.response(kind)
        self._conclude(answer, handle(request, answer))
        return answer

    def _conclude(self, answer: Any, result: Any) -> None:
        """Write into an answer what its handler returned, as the driver does."""

    def _offer_parameters(self, package: str, values: Mapping[str, Any]) -> None:
        """Give parameters to a controller that uses a package of messages."""
        for name, value in values.items():
            self._graph.parameters.offer(name, partial(self._if_used, package, value))

    def _if_used(self, package: str, value: Any) -> Any:
        return value if self._messages.is_used(package) else None

    # Topics

    def _hear(self, name: str, type_name: str, take: Callable[[Any, Publication], Any]) -> None:
        """Give `take` the messages of a topic, once however many publish on it."""
        key = self._key(name, type_name)
        if key not in self._heard:
            self._heard.add(key)
            self._graph.subscribe(name, type_name, take, node=self.node, by_controller=False)

    def _if_commanded(self, take: Callable[[str, Any], None]) -> Callable[[Any, Publication], None]:
        """Return what passes on, with the topic, what controllers send and none of them hears."""

        def deliver(message: Any, publication: Publication) -> None:
            others = self._graph.subscriptions(publication.topic)
            if publication.by_controller and not any(other.by_controller for other in others):
                take(publication.topic, message)

        return deliver

    def _report_on(
        self,
        name: str,
        type_name: str,
        hz: float,
        make: Callable[[Any, str], Any],
        sensors: Sequence[SensorKind] = (),
        *,
        latch: bool = False,
    ) -> None:
        """Publish `hz` times a second while somebody subscribes.

        `make` fills an empty message for a topic and returns it, or None where there is no more
        to report. It is read of `sensors`.
        """
        key = self._key(name, type_name)
        if key in self._reported:
            return
        self._reported.add(key)
        publication = self._graph.advertise(
            name, type_name, node=self.node, latch=latch, by_controller=False
        )
        if sensors:
            self._reading.reports(publication, self._reading.named(*sensors), hz)
        self._schedule(publication, round(1e9 / hz), make, is_first=True)

    def _schedule(
        self,
        publication: Publication,
        period_ns: int,
        make: Callable[[Any, str], Any],
        *,
        is_first: bool = False,
    ) -> None:
        due_ns = self._next_ns(period_ns, is_first=is_first)
        self._scheduler.call_at(
            due_ns, lambda: self._tick(publication, period_ns, make), background=True
        )

    def _next_ns(self, period_ns: int, *, is_first: bool) -> int:
        """Return when the next message of a topic is due: at whole periods of the run."""
        del is_first
        return (self._scheduler.now_ns // period_ns + 1) * period_ns

    def _tick(
        self, publication: Publication, period_ns: int, make: Callable[[Any, str], Any]
    ) -> None:
        topic, type_name = publication.topic, publication.type_name
        message = None
        if publication.is_wanted:
            message = make(self._messages.new(type_name), topic)
        if message is None:
            self._reported.discard(self._key(topic, type_name))
            publication.close()
            return
        publication.publish(message)
        self._schedule(publication, period_ns, make)

    def _stream(
        self,
        name: str,
        type_name: str,
        hz: float,
        make: Callable[[], Any],
        sensors: Sequence[str] = (),
        *,
        yields: bool = False,
    ) -> None:
        """Begin a `TopicStream`, which is read of some sensors, by name."""
        publication = self._graph.advertise(name, type_name, node=self.node, by_controller=False)
        if sensors:
            self._reading.reports(publication, sensors, hz)
        TopicStream(self._runtime, publication, hz, make, yields=yields)

    def _now(self, header: Any) -> None:
        self._messages.stamp(header, self._scheduler.now_ns)


class TopicStream:
    """Publishes what `make` makes, `hz` times a second, while the topic has a subscription.

    Where it makes `None`, nothing is published.
    One that `yields` is silent where somebody else publishes on the topic: a maker's driver.
    """

    def __init__(
        self,
        runtime: Runtime,
        publication: Publication,
        hz: float,
        make: Callable[[], Any],
        *,
        yields: bool = False,
    ) -> None:
        self._graph = runtime.graph
        self._yields = yields
        self._scheduler = runtime.scheduler
        self._publication = publication
        self._period_ns = round(1e9 / hz)
        self._make = make
        self._is_ticking = False
        runtime.graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        del type_name
        if change == "subscribed" and name == self._publication.topic and not self._is_ticking:
            self._is_ticking = True
            self._schedule()

    def _schedule(self) -> None:
        following_ns = (self._scheduler.now_ns // self._period_ns + 1) * self._period_ns
        self._scheduler.call_at(following_ns, self._tick, background=True)

    def _tick(self) -> None:
        if not self._publication.is_wanted:
            self._is_ticking = False
            return
        if not self._yields or len(self._graph.publications(self._publication.topic)) == 1:
            message = self._make()
            if message is not None:
                self._publication.publish(message)
        self._schedule()
