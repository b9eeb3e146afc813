"""The world that a scenario describes, given to one run.

What the controller itself serves comes before the scenario, and the scenario before the twin.
"""

from __future__ import annotations

from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.graph.parameter_files import into_tree
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.imports.placeholder_modules import is_placeholder
from tracerisk.ros.scenario.calls import ScenarioCall
from tracerisk.ros.scenario.frames import ScenarioFrames
from tracerisk.ros.scenario.known_objects import add_known_objects
from tracerisk.ros.scenario.scenario import Scenario
from tracerisk.ros.scenario.schedule import Schedule
from tracerisk.ros.scenario.servers import ScenarioAction, ScenarioService
from tracerisk.ros.scenario.topics import ScenarioTopic

_SOON_NS = 3_000_000_000


class ScenarioWorld:
    """Publishes, answers and broadcasts what a scenario says.

    `interfaces` makes the message classes of the ROS that the controller speaks. `schedule`
    knows whether anything is still to come.

    Raises:
        ScenarioError: a type is not known, or a message does not fit its type.
    """

    def __init__(self, runtime: Runtime, interfaces: Any, scenario: Scenario) -> None:
        self.schedule = Schedule(runtime.scheduler)
        self._parameters = scenario.parameters
        self._unconfirmed = scenario.unconfirmed
        self._modules = scenario.modules
        self._interfaces = interfaces
        self._asked = runtime.graph.parameters
        into_tree(runtime.parameters, runtime.graph.parameters)
        self._services = [
            ScenarioService(runtime, interfaces, service) for service in scenario.services
        ]
        self._actions = [
            ScenarioAction(runtime, interfaces, self.schedule, action)
            for action in scenario.actions
        ]
        add_known_objects(runtime, interfaces, scenario.objects)
        ScenarioFrames(runtime, interfaces, self.schedule, scenario.frames)
        self._calls: list[ScenarioCall] = []
        for call in scenario.calls:
            before = self._calls[-1] if self._calls else None
            self._calls.append(ScenarioCall(runtime, interfaces, self.schedule, call, before))
        self._topics = [
            ScenarioTopic(runtime, interfaces, self.schedule, published)
            for published in scenario.published
        ]

    def unanswered(self) -> tuple[tuple[str, Location, bool], ...]:
        """Return the goals that it sent and that have no result, as `ScenarioCall.unanswered`."""
        return tuple(row for call in self._calls for row in call.unanswered)

    def firsts_come_ns(self) -> int:
        """Return when all first messages have come that the controller listens to; 0 for none.

        Those that come much later are for what it does by then.
        """
        until_ns = self.schedule.now_ns + _SOON_NS
        due = (topic.first_ns for topic in self._topics)
        return max(
            (number for number in due if number is not None and number <= until_ns), default=0
        )

    def unused(self) -> tuple[tuple[str, Location, str], ...]:
        """Return what nobody made use of, in words and with its place: a name may be mistaken.

        The third is the entry in words where nobody has confirmed it, else empty.
        """
        pairs = [
            *(service.unused for service in self._services),
            *(action.unused for action in self._actions),
            *(call.unused for call in self._calls),
            *(topic.unused for topic in self._topics),
            *(
                (f"nobody asked for parameter {parameter.name}", parameter.location)
                for parameter in self._parameters
                if parameter.location is not None and not self._asked.is_asked(parameter.name)
            ),
            *(
                (f"no placeholder was needed for module {name}", place)
                for name, place in self._modules
                if not is_placeholder(name) and not self._interfaces.is_used(name)
            ),
        ]
        return tuple(
            (text, place, next((e.what for e in self._unconfirmed if e.holds(place)), ""))
            for text, place in (item for item in pairs if item is not None)
        )
