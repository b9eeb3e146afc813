"""What of the settings a scenario gives: the robot and the controller's command line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tracerisk.config import Settings
from tracerisk.ros.scenario.file.scenario_reader import read_scenario


def with_scenario(settings: Settings) -> Settings:
    """Return the settings with the robot and the arguments of the scenario where they have none.

    Raises ScenarioError where the scenario cannot be read.
    """
    if settings.scenario is None or (settings.robot is not None and settings.args):
        return settings

    scenario = read_scenario(Path(settings.scenario))
    return replace(
        settings,
        robot=settings.robot or scenario.robot,
        args=settings.args or scenario.arguments,
    )
