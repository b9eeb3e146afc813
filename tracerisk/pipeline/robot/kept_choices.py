"""What was chosen for a controller, kept for its further runs: its sources stay as they are."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import LaunchChoice, choose_launch
from tracerisk.pipeline.robot.choice import RobotChoice, choose_launched_robot
from tracerisk.pipeline.workspace.controller import Controller


@dataclass(slots=True)
class KeptChoices:
    """The launch file and the robots of one controller, whose workspace is read once for each.

    Reading them takes processes for launch files and descriptions, as long as many a run.
    Of the settings only the robot may be another from run to run.
    """

    in_vain: set[Hashable] = field(default_factory=set, init=False)
    """How runs ended, and what they lacked, for which no node beside the controller helped."""

    _launch: LaunchChoice | None = field(default=None, init=False)
    """What the launch file gives; `None` before it was chosen."""
    _robots: list[tuple[LaunchChoice, str | None, tuple[str, ...], RobotChoice]] = field(
        default_factory=list, init=False
    )
    """The chosen robot for each launch choice, robot setting and further names."""

    def launch(self, controller: Controller, settings: Settings) -> LaunchChoice:
        """Return what `choose_launch` does."""
        if self._launch is None:
            self._launch = choose_launch(controller, settings)
        return self._launch

    def robot(
        self,
        controller: Controller,
        settings: Settings,
        launch: LaunchChoice,
        also_named: tuple[str, ...],
    ) -> RobotChoice:
        """Return what `choose_launched_robot` does, and raise what it raises."""
        for known, name, names, choice in self._robots:
            if (known, name, names) == (launch, settings.robot, also_named):
                return choice
        choice = choose_launched_robot(controller, settings, launch, also_named=also_named)
        self._robots.append((launch, settings.robot, also_named, choice))
        return choice
