"""Calls and goals that a scenario sends to what the controller itself serves."""

from __future__ import annotations

import contextlib
import itertools
from typing import Any

from tracerisk.errors import InputError, Location, ScenarioError
from tracerisk.ros.action_graph import Actions
from tracerisk.ros.graph import ServiceFailedError, ServiceServer
from tracerisk.ros.runtime import Runtime
from tracerisk.ros.scenario import full_name, interface_type, written_at
from tracerisk.ros.scenario_lines import goal_class, service_parts
from tracerisk.ros.scenario_message import MessageTemplate
from tracerisk.ros.scenario_schedule import Schedule
from tracerisk.ros.scenario_topics import NODE
from tracerisk.yaml_reader import YamlMap

_KEYS = {"service": "request", "action": "goal"}


class ScenarioCall:
    """One entry of `calls`: sent at its times, or once when the controller begins to serve.

    What a call at a time finds nobody to serve is not sent.

    Raises:
        ScenarioError: the entry is malformed, or what it sends does not fit its type.
    """

    def __init__(
        self, runtime: Runtime, interfaces: Any, schedule: Schedule, entry: YamlMap
    ) -> None:
        given = [key for key in _KEYS if key in entry]
        if len(given) != 1:
            raise ScenarioError("expected exactly one of service and action", entry.location)
        (self._kind,) = given
        content = _KEYS[self._kind]
        entry.forbid_unknown({self._kind, "type", content, "at"})
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
        if "at" in entry:
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

    def _on_served(self, change: str, name: str, type_name: str) -> None:
        if change == "served" and (name, type_name) == (self._name, self._type):
            self._schedule.at(self._schedule.now_ns, self._send_once)

    def _send_once(self) -> None:
        if not self._is_sent:
            self._send()

    def _send(self) -> None:
        if self._kind == "service":
            server = self._runtime.graph.service(self._name)
            if server is not None and server.is_callback and server.type_name == self._type:
                self._is_sent = True
                self._call(server)
            return
        actions = self._runtime.client(Actions)
        served = actions.server(self._name, self._type)
        if served is not None and served.by_controller:
            self._is_sent = True
            number = next(self._numbers)
            client = actions.client(self._name, self._type, node=NODE)
            client.send(
                self._message.make(self._schedule.now_ns),
                goal_id=number.to_bytes(16, "big") if self._is_ros2 else f"{NODE}-{number}",
            )

    def _call(self, server: ServiceServer) -> None:
        request = self._message.make(self._schedule.now_ns)

        def call() -> None:
            with contextlib.suppress(ServiceFailedError):
                self._runtime.graph.call(server, request)

        self._runtime.scheduler.spawn(
            call, f"call of {self._name}", inherit=False, is_controllers=False
        )
