"""Services that a scenario answers, with what it says or with the defaults of their type."""

from __future__ import annotations

from typing import Any

from tracerisk.errors import InputError, Location, ScenarioError
from tracerisk.ros.graph.graph import ServiceFailedError
from tracerisk.ros.graph.names import ANY_TYPE
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.messages.fields import service_parts, type_of
from tracerisk.ros.scenario.message import MessageTemplate
from tracerisk.ros.scenario.scenario import Served
from tracerisk.ros.scenario.topics import NODE


class ScenarioService:
    """One entry of `services`; one without a type has that of the request that it is asked.

    Raises:
        ScenarioError: the type is not known, or a reply does not fit it.
    """

    def __init__(self, runtime: Runtime, interfaces: Any, entry: Served) -> None:
        self._scheduler = runtime.scheduler
        self._interfaces = interfaces
        self._entry = entry
        self._calls = 0
        self._replies: list[MessageTemplate] = []
        if entry.type_name is not None:
            self._replies = self._templates(entry.type_name)
        runtime.graph.serve(
            entry.name, entry.type_name or ANY_TYPE, self._answer, node=NODE, is_callback=False
        )

    @property
    def unused(self) -> tuple[str, Location] | None:
        """What nobody made use of, in words, and its place; None where somebody did."""
        if self._calls:
            return None
        return f"nobody called service {self._entry.name}", self._entry.location

    def _templates(self, type_name: str) -> list[MessageTemplate]:
        try:
            response = service_parts(self._interfaces, type_name)[1]
        except InputError as error:
            raise ScenarioError(error.message, self._entry.location) from error
        return [MessageTemplate(response, each) for each in self._entry.replies]

    def _answer(self, request: Any) -> Any:
        number, self._calls = self._calls, self._calls + 1
        if self._entry.after > 0.0:
            self._scheduler.sleep(round(self._entry.after * 1e9))
        if self._entry.fails is not None:
            raise ServiceFailedError(self._entry.fails)
        if not self._replies:
            asked = type_of(type(request))
            self._replies = self._templates(asked.removesuffix("Request").removesuffix("_"))
        template = self._replies[min(number, len(self._replies) - 1)]
        return template.make(self._scheduler.now_ns)
