"""Calls and goals that a scenario sends to what the controller itself serves."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterator
from typing import Any

from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import InputError, Location, ScenarioError
from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.services import ServiceFailedError, ServiceServer
from tracerisk.ros.messages.fields import goal_class, service_parts
from tracerisk.ros.scenario.file.scenario_reader import full_name, interface_type, written_at
from tracerisk.ros.scenario.message import MessageTemplate
from tracerisk.ros.scenario.schedule import Schedule
from tracerisk.ros.scenario.topics import NODE

_KEYS = {"service": "request", "action": "goal"}
_LOOK_NS = 500_000_000
_RESTS = 2  # looks at which nothing moves
_PASSED_OVER = 10  # looks at which this one is served, and nobody serves the entries above
_PATIENCE_NS = 120_000_000_000  # how long a run goes on for a turn that does not come


class ScenarioCall:
    """One entry of `calls`: sent at its times, or once when the controller begins to serve.

    What a call at a time finds nobody to serve is not sent. One that waits is sent when the entry
    `before` it was answered and the robot has come to rest, or so many seconds later. What nobody
    serves is passed over.

    Raises:
        ScenarioError: the entry is malformed, or what it sends does not fit its type.
    """

    def __init__(
        self,
        runtime: Runtime,
        interfaces: Any,
        schedule: Schedule,
        entry: YamlMap,
        before: ScenarioCall | None = None,
    ) -> None:
        given = [key for key in _KEYS if key in entry]
        if len(given) != 1:
            raise ScenarioError("expected exactly one of service and action", entry.location)
        (self._kind,) = given
        content = _KEYS[self._kind]
        entry.forbid_unknown({self._kind, "type", content, "at", "wait"})
        self._runtime = runtime
        self._schedule = schedule
        self._location = entry.key_location(self._kind)
        self._name, self._type = full_name(entry, self._kind), interface_type(entry, "type")
        try:
            made: Any = (
                service_parts(interfaces, self._type)[0]
                if self._kind == "service"
                else goal_class(interfaces, self._type)
            )
        except InputError as error:
            raise ScenarioError(error.message, entry.key_location("type")) from error
        self._message = MessageTemplate(
            made, written_at(entry, content) if content in entry else None
        )
        self._numbers = itertools.count(1)
        self._is_ros2 = hasattr(interfaces, "action")
        self._is_sent = False
        self._is_answered: Callable[[], bool] = lambda: False
        self._goals: list[ActionGoal] = []
        self._before = before
        self._rests = 0
        self._served_for = 0
        waits, later_s = _turn(entry)
        self._later_ns = round(later_s * 1e9)
        if waits and "at" in entry:
            entry.fail("wait", "a call is sent at a time or in its turn; keep one of at and wait")
        if waits:
            schedule.at(schedule.now_ns, self._look)
        elif "at" in entry:
            times = entry.numbers("at") if isinstance(entry.get("at"), list) else None
            for seconds in times if times is not None else [entry.number("at", minimum=0.0)]:
                schedule.at(round(seconds * 1e9), self._send)
        elif self._kind == "service":
            runtime.graph.watch(self._on_served)
        else:
            runtime.client(Actions).watch(self._on_served)

    @property
    def unused(self) -> tuple[str, Location] | None:
        """What nobody made use of, in words, and its place; None where somebody did."""
        if self._is_sent:
            return None
        return f"nobody served {self._kind} {self._name}", self._location

    @property
    def unanswered(self) -> Iterator[tuple[str, Location, bool]]:
        """Each goal without a result: in words, its place, and whether the server has taken it.

        The thread of a service's call shows by itself what it waits for.
        """
        for goal in self._goals:
            if goal.state.is_terminal:
                continue
            is_taken = goal.state is not GoalState.PENDING
            became = "accepted and never ended" if is_taken else "never taken by its server"
            sent = f"the goal of action {self._name} sent at {goal.sent_ns / 1e9:g} s"
            yield f"{sent} was {became}", self._location, is_taken

    def _on_served(self, change: str, name: str, type_name: str) -> None:
        if change == "served" and (name, type_name) == (self._name, self._type):
            self._schedule.at(self._schedule.now_ns, self._send_once)

    def _look(self) -> None:
        """Send the call if it is its turn; else look again."""
        twin = self._runtime.twin
        self._served_for += self._is_served
        before = self._last_served() if self._served_for > _PASSED_OVER else self._before
        is_turn = before is None or before._is_answered()
        is_at_rest = twin is None or not twin.busy
        self._rests = self._rests + 1 if is_turn and is_at_rest and self._is_served else 0
        if self._rests >= _RESTS:
            if self._later_ns:
                self._schedule.at(self._schedule.now_ns + self._later_ns, self._send)
            else:
                self._send()
            return
        awaited = self._schedule.now_ns < _PATIENCE_NS or self._rests > 0
        self._schedule.at(
            self._schedule.now_ns + _LOOK_NS, self._look, awaited=awaited, background=not awaited
        )

    def _last_served(self) -> ScenarioCall | None:
        """Return the last entry above that was sent or can be; a turn nobody takes is passed."""
        before = self._before
        while before is not None and not (before._is_sent or before._is_served):
            before = before._before
        return before

    @property
    def _is_served(self) -> bool:
        if self._kind == "service":
            server = self._runtime.graph.services.find(self._name)
            return server is not None and server.is_callback and server.type_name == self._type
        served = self._runtime.client(Actions).server(self._name, self._type)
        return served is not None and served.by_controller

    def _send_once(self) -> None:
        if not self._is_sent:
            self._send()

    def _send(self) -> None:
        if not self._is_served:
            return
        self._is_sent = True
        if self._kind == "service":
            server = self._runtime.graph.services.find(self._name)
            assert server is not None
            self._call(server)
            return
        actions = self._runtime.client(Actions)
        number = next(self._numbers)
        # Whoever sends a scenario's goals was there before, connected like all of the cell.
        client = actions.client(self._name, self._type, node=NODE, by_controller=False)
        goal = client.send(
            self._message.make(self._schedule.now_ns),
            goal_id=number.to_bytes(16, "big") if self._is_ros2 else f"{NODE}-{number}",
        )
        self._goals.append(goal)
        self._is_answered = lambda: goal.state.is_terminal

    def _call(self, server: ServiceServer) -> None:
        request = self._message.make(self._schedule.now_ns)

        def call() -> None:
            with contextlib.suppress(ServiceFailedError):
                self._runtime.graph.services.call(server, request)

        thread = self._runtime.scheduler.spawn(
            call, f"call of {self._name}", inherit=False, is_controllers=False
        )
        self._is_answered = lambda: thread.finished


def _turn(entry: YamlMap) -> tuple[bool, float]:
    """Return whether a call waits for its turn, and for how long then [s]."""
    if isinstance(entry.get("wait"), bool | None):
        return entry.boolean("wait", default=False), 0.0
    return True, entry.number("wait", minimum=0.0, maximum=1e6)
