"""Parameters that a launch file leaves open: the robot, which whoever starts it has to name.

`<arg name="robot_name" default=""/>` is filled on the command line, `robot_name:=wx200`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from tracerisk.pipeline.launch_files.records import LaunchParameter

_OF_ROBOTS = ("robot_name", "robot_model", "robot_type", "arm_model", "arm_name")

OnFilled = Callable[[str, str], None]
"""Called with the name of a parameter, and with the words on what it was given."""


def filled(
    parameters: Iterable[LaunchParameter], robot: str, on_filled: OnFilled
) -> Iterator[LaunchParameter]:
    """Yield the parameters, those that name the robot and are empty with the robot's name."""
    told: set[str] = set()
    for parameter in parameters:
        name = parameter.name.rpartition("/")[2]
        if parameter.value == "" and name in _OF_ROBOTS:
            if name not in told:
                words = f"the launch file leaves {name} open: '{robot}' is taken for it"
                on_filled(name, words)
            told.add(name)
            yield replace(parameter, value=robot)
        else:
            yield parameter
