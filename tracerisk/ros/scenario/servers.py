"""What a scenario serves: services that it answers, and actions of whose goals it says the end.

An answer is what it says, or the defaults of its type.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from tracerisk.errors import InputError, Location, ScenarioError
from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.graph_names import ANY_TYPE
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.services import ServiceFailedError
from tracerisk.ros.messages.fields import action_parts, service_parts, type_of
from tracerisk.ros.scenario.message import MessageTemplate
from tracerisk.ros.scenario.scenario import GoalScript, Served, ServedAction
from tracerisk.ros.scenario.schedule import Schedule
from tracerisk.ros.scenario.topics import NODE


@dataclass(frozen=True, slots=True)
class _Outcome:
    """A goal's script with its messages ready to be filled."""

    script: GoalScript
    """The script from the scenario."""
    result: MessageTemplate
    """The result message."""
    feedback: tuple[MessageTemplate, ...]
    """The feedback messages in turn."""


class ScenarioAction:
    """One entry of `actions`.

    Raises:
        ScenarioError: the type is not known, or a result or a feedback does not fit it.
    """

    def __init__(
        self, runtime: Runtime, interfaces: Any, schedule: Schedule, entry: ServedAction
    ) -> None:
        try:
            result, feedback = action_parts(interfaces, entry.type_name)
        except InputError as error:
            raise ScenarioError(error.message, entry.location) from error
        self._entry = entry
        self._schedule = schedule
        self._needs = runtime.scheduler.needs
        self._goals = 0
        self._outcomes = [
            _Outcome(
                script,
                MessageTemplate(result, script.result),
                tuple(MessageTemplate(feedback, written) for written in script.feedback),
            )
            for script in entry.goals
        ]
        runtime.client(Actions).serve(
            entry.name,
            entry.type_name,
            node=NODE,
            on_goal=self._on_goal,
            on_cancel=self._on_cancel,
            by_controller=False,
            is_scenario=True,
        )

    @property
    def unused(self) -> tuple[str, Location] | None:
        """What nobody made use of, in words, and its place; None where somebody did."""
        if self._goals or self._needs.is_met("action", self._entry.name):
            return None
        return f"nobody sent a goal to action server {self._entry.name}", self._entry.location

    def _on_goal(self, goal: ActionGoal) -> None:
        outcome = self._outcomes[min(self._goals, len(self._outcomes) - 1)]
        self._goals += 1
        script = outcome.script
        goal.data = outcome
        if script.status == "rejected":
            goal.reject(script.text, outcome.result.make(self._schedule.now_ns))
            return
        goal.accept()
        began_ns = self._schedule.now_ns
        length_ns = round(script.after * 1e9)
        count = len(outcome.feedback)
        for index, feedback in enumerate(outcome.feedback):
            due_ns = began_ns + length_ns * (index + 1) // (count + 1)
            self._schedule.at(due_ns, partial(self._feed_back, goal, feedback))
        self._schedule.at(began_ns + length_ns, lambda: self._finish(goal, outcome))

    def _on_cancel(self, goal: ActionGoal) -> None:
        goal.accept_cancel()
        outcome: _Outcome = goal.data
        goal.cancel(outcome.result.make(self._schedule.now_ns), outcome.script.text)

    def _feed_back(self, goal: ActionGoal, feedback: MessageTemplate) -> None:
        if not goal.state.is_terminal:
            goal.publish_feedback(feedback.make(self._schedule.now_ns))

    def _finish(self, goal: ActionGoal, outcome: _Outcome) -> None:
        if goal.state.is_terminal:
            return
        result, text = outcome.result.make(self._schedule.now_ns), outcome.script.text
        end = {"succeeded": goal.succeed, "aborted": goal.abort, "canceled": goal.cancel}
        end[outcome.script.status](result, text)


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
        runtime.graph.services.serve(
            entry.name,
            entry.type_name or ANY_TYPE,
            self._answer,
            node=NODE,
            is_callback=False,
            is_scenario=True,
        )

    @property
    def unused(self) -> tuple[str, Location] | None:
        """What nobody made use of, in words, and its place; None where somebody did."""
        if self._calls or self._scheduler.needs.is_met("service", self._entry.name):
            return None
        return f"nobody called service {self._entry.name}", self._entry.location

    def _templates(self, type_name: str) -> list[MessageTemplate]:
        try:
            response = service_parts(self._interfaces, type_name)[1]
        except InputError as error:
            raise ScenarioError(error.message, self._entry.location) from error
        return [MessageTemplate(response, reply) for reply in self._entry.replies]

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
