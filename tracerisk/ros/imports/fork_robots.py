"""`pymoveit2.robots.NAME` of a robot that only forks of the library have.

Its names are those of the twin's robot, and the run says so.
"""

from __future__ import annotations

import sys
import sysconfig
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any

from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.imports.cfg_modules import FilledLoader
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.robot import Robot

_PARENT = "pymoveit2.robots"


def robot_of_a_fork(fullname: str) -> ModuleSpec | None:
    """Return the spec of the module of a robot; None for all else, and in an author's own fork."""
    parent, _, name = fullname.rpartition(".")
    if parent != _PARENT or name.startswith("_"):
        return None
    if not Path(str(sys.modules[parent].__file__)).is_relative_to(sysconfig.get_path("purelib")):
        return None
    return ModuleSpec(fullname, FilledLoader(lambda _: _names(name)))


def _names(module: str) -> dict[str, Any]:
    robot = current().twin.robot
    current().recorder.finding(
        "unprovided",
        f"pymoveit2.robots has no '{module}', which a fork of the library may have: the names of "
        f"its joints, links and groups are those of {robot.name}; put the fork's sources into the "
        "workspace",
        asking_place(),
    )
    return names_of(robot)


def names_of(robot: Robot) -> dict[str, Any]:
    """Return what a module of AndrejOrsula/pymoveit2 pymoveit2/robots holds, for a robot."""
    held = {joint for gripper in robot.grippers for joint in gripper.joints}
    arm = max(robot.groups, key=lambda group: len({*robot.groups[group].joints} - held))
    joints = [joint for joint in robot.groups[arm].joints if joint not in held]
    tip = robot.groups[arm].tip_link or robot.links[-1].name
    names: dict[str, Any] = {
        "MOVE_GROUP_ARM": arm,
        "MOVE_GROUP_GRIPPER": "gripper",
        "OPEN_GRIPPER_JOINT_POSITIONS": [],
        "CLOSED_GRIPPER_JOINT_POSITIONS": [],
    }
    fingers: list[str] = []
    if robot.grippers:
        gripper = robot.grippers[0]
        ends, fingers = gripper_ends(robot, gripper), list(gripper.joints)
        names["MOVE_GROUP_GRIPPER"] = gripper.group
        names["OPEN_GRIPPER_JOINT_POSITIONS"] = [sign * ends.opened for sign in gripper.signs]
        names["CLOSED_GRIPPER_JOINT_POSITIONS"] = [sign * ends.closed for sign in gripper.signs]
    return {
        **names,
        "joint_names": lambda *_, **__: list(joints),
        "base_link_name": lambda *_, **__: robot.base_link,
        "end_effector_name": lambda *_, **__: tip,
        "gripper_joint_names": lambda *_, **__: list(fingers),
    }
