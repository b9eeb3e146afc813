"""Read which groups of a MoveIt package have a solver of inverse kinematics for positions only."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tracerisk.text.yaml_reader import YamlMap
from tracerisk.twin.robots.robot import Group, Robot
from tracerisk.twin.urdf.srdf import yaml_beside

NAME = "kinematics.yaml"
_ALL_AXES = 6  # joints that it takes to bring a link to any pose
_OF_ITS_ARM = "ikfast"  # such a solver is made for what its arm can reach


def solved_as_beside(robot: Robot, srdf: Path, *, shown: str) -> tuple[Robot, Path | None]:
    """Return the robot with the solvers of the kinematics.yaml beside its SRDF, and that file.

    It stands in the folder of the SRDF or in `config` beside that; `None` where there is none, or
    nothing in it changes the robot. A group turns freely where `position_only_ik` is set, and where
    an arm of fewer than six joints has a solver made for it (IKFast): it does what it can.
    `shown` is the SRDF's name for messages.
    Raises RobotError with file and line for a file that is not YAML.
    """
    found = yaml_beside(srdf, NAME, shown=shown)
    if found is None:
        return robot, None
    top, path = found
    groups = {
        name: replace(group, turns_freely=True)
        if isinstance(top.get(name), dict) and _is_of_positions(top.map(name), group)
        else group
        for name, group in robot.groups.items()
    }
    solved = replace(robot, groups=groups)
    return (robot, None) if solved == robot else (solved, path)


def _is_of_positions(entry: YamlMap, group: Group) -> bool:
    if entry.get("position_only_ik") is True:
        return True
    solver = str(entry.get("kinematics_solver") or "")
    return len(group.joints) < _ALL_AXES and _OF_ITS_ARM in solver.lower()
