"""Messages that a scenario publishes: at times, at a rate, to who subscribes, or as answers."""

from __future__ import annotations

from typing import Any

from tracerisk.errors import InputError, Location, ScenarioError
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.graph.topic_ends import Publication, Subscription
from tracerisk.ros.scenario.message import MessageTemplate
from tracerisk.ros.scenario.scenario import Published
from tracerisk.ros.scenario.schedule import Schedule
from tracerisk.ros.scenario.sensor_topics import reporting_sensors

NODE = "/scenario"


class ScenarioTopic:
    """One entry of `publish`.

    Raises:
        ScenarioError: the type is not known, or a message does not fit it.
    """

    def __init__(
        self, runtime: Runtime, interfaces: Any, schedule: Schedule, entry: Published
    ) -> None:
        try:
            message_class = interfaces.message(entry.type_name)
        except InputError as error:
            raise ScenarioError(error.message, entry.type_location) from error
        self._entry = entry
        self._schedule = schedule
        self._messages = [MessageTemplate(message_class, message) for message in entry.messages]
        self._sent = 0
        self._first_ns: int | None = None
        self._is_heard = False
        self._publication: Publication = runtime.graph.advertise(
            entry.topic,
            entry.type_name,
            node=NODE,
            by_controller=False,
            on_connect=self._on_subscriber if self._is_for_each else None,
        )
        if entry.when:
            runtime.graph.when_sent(entry.when, self._on_sent)
        # What it publishes at an instant comes from a cell that is up and waits for who listens.
        self._publication.keeps_for_late = bool(entry.at) and entry.rate is None
        robot = getattr(runtime.twin, "robot", None)
        if robot is not None:
            runtime.client(SensorReading).reports(
                self._publication, reporting_sensors(robot, entry), entry.rate
            )
        if entry.at or entry.rate is not None:
            self._first_ns = round(min(entry.at, default=0.0) * 1e9)
        if entry.rate is not None:
            self._begin_rate(entry.rate, entry.at[0] if entry.at else 0.0)
        else:
            for seconds in entry.at:
                schedule.at(round(seconds * 1e9), self._publish)

    @property
    def _is_for_each(self) -> bool:
        """Whether each who subscribes gets a message of its own."""
        entry = self._entry
        return not (entry.at or entry.when or entry.rate is not None)

    @property
    def unused(self) -> tuple[str, Location] | None:
        """What nobody made use of, in words, and its place; None where somebody did."""
        if self._entry.when and self._first_ns is None:
            words = f"the controller sent nothing to {self._entry.when}"
            return words, self._entry.type_location
        if self._is_heard or self._has_listener():
            return None
        if not self._sent and self._first_ns is not None:
            due_s = self._first_ns / 1e9
            if self._first_ns > self._schedule.now_ns:
                words = f"the run ended before {self._entry.topic} was due, at {due_s:g} s"
                return words, self._entry.type_location
        return f"nobody subscribed to topic {self._entry.topic}", self._entry.type_location

    @property
    def first_ns(self) -> int | None:
        """When the first message comes to a controller that listens; None where it has come."""
        known = self._publication.graph.subscriptions(self._publication.topic)
        if self._sent or not any(subscription.by_controller for subscription in known):
            return None
        if self._first_ns is None and not self._is_for_each:
            return None
        if self._first_ns is None:
            # The subscription is about to be connected.
            return self._schedule.now_ns + round(self._entry.after * 1e9)
        return self._first_ns

    def _has_listener(self) -> bool:
        known = self._publication.subscriptions
        return any(
            subscription.by_controller or subscription.hears_scenario for subscription in known
        )

    def _on_subscriber(self, subscription: Subscription) -> None:
        # What the twin itself listens to asks for nothing.
        if not subscription.by_controller:
            return
        due_ns = self._schedule.now_ns + round(self._entry.after * 1e9)
        if self._first_ns is None:
            self._first_ns = due_ns
        self._schedule.at(due_ns, lambda: self._publish(subscription))

    def _on_sent(self) -> None:
        due_ns = self._schedule.now_ns + round(self._entry.after * 1e9)
        if self._first_ns is None:
            self._first_ns = due_ns
        self._schedule.at(due_ns, self._publish)

    def _begin_rate(self, rate: float, begin_s: float) -> None:
        entry = self._entry
        count = entry.count
        if entry.until is not None:
            until = int((entry.until - begin_s) * rate + 1e-9) + 1
            count = until if count is None else min(count, until)
        begin_ns = round(begin_s * 1e9)

        def tick(number: int) -> None:
            self._publish()
            follow(number + 1)

        def follow(number: int) -> None:
            if count is None or number < count:
                due_ns = begin_ns + round(number * 1e9 / rate)
                # A stream without an end is nothing that a run has to wait for.
                awaited = count is not None or number == 0
                unheard = not awaited and not self._publication.subscriptions
                self._schedule.at(due_ns, lambda: tick(number), awaited=awaited, background=unheard)

        follow(0)

    def _publish(self, only: Subscription | None = None) -> None:
        if only is not None and only.closed:
            return
        template = self._messages[min(self._sent, len(self._messages) - 1)]
        self._sent += 1
        message = template.make(self._schedule.now_ns)
        self._is_heard |= self._has_listener()
        if only is None:
            self._publication.publish(message)
        elif only in self._publication.subscriptions:
            only.receive(message, self._publication)
