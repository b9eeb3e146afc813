"""The module of a robot that the library lacks, with the names of the twin's robot."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.robot import Robot


def module_of(robot: Robot, name: str) -> ModuleType:
    """Return a module as those of AndrejOrsula/pymoveit2 pymoveit2/robots, of a robot."""
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
    module = ModuleType(name, f"Names of {robot.name}.")
    vars(module).update(
        names,
        joint_names=lambda *_, **__: list(joints),
        base_link_name=lambda *_, **__: robot.base_link,
        end_effector_name=lambda *_, **__: tip,
        gripper_joint_names=lambda *_, **__: list(fingers),
    )
    return module
