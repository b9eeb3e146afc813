"""The world that a scenario describes, given to one run.

What the controller itself serves comes before the scenario, and the scenario before the twin.
"""

from __future__ import annotations

from typing import Any

from tracerisk.ros.runtime import Runtime
from tracerisk.ros.scenario import Scenario
from tracerisk.ros.scenario_actions import ScenarioAction
from tracerisk.ros.scenario_frames import ScenarioFrames
from tracerisk.ros.scenario_parameters import into_tree
from tracerisk.ros.scenario_schedule import Schedule
from tracerisk.ros.scenario_services import ScenarioService
from tracerisk.ros.scenario_topics import ScenarioTopic


class ScenarioWorld:
    """Publishes, answers and broadcasts what a scenario says.

    `interfaces` makes the message classes of the ROS that the controller speaks. `schedule`
    tells whether anything is still to come.

    Raises:
        ScenarioError: a type is not known, or a message does not fit its type.
    """

    def __init__(self, runtime: Runtime, interfaces: Any, scenario: Scenario) -> None:
        self.schedule = Schedule(runtime.scheduler)
        into_tree(runtime.parameters, runtime.graph.parameters)
        for service in scenario.services:
            ScenarioService(runtime, interfaces, service)
        for action in scenario.actions:
            ScenarioAction(runtime, interfaces, self.schedule, action)
        ScenarioFrames(runtime, interfaces, self.schedule, scenario.frames)
        for topic in scenario.published:
            ScenarioTopic(runtime, interfaces, self.schedule, topic)
