"""A gripper on an arm that is sold without one, for a controller that commands one.

Which gripper it is, nobody says: every figure is assumed.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterable
from dataclasses import replace
from types import MappingProxyType

from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.robots.generic import FINGER_OPENING, sliding_fingers
from tracerisk.twin.robots.robot import Controller, Group, Robot

NAME = "gripper"
_COMMANDS = frozenset({"GripperCommand", "GripperCommandAction", "ParallelGripperCommand"})
_NAMED = re.compile(r"(?:^|.*[/_.])(?:\w*gripper|robotiq)\w*(?:/\S*)?|hand", re.IGNORECASE)
_FINGER = re.compile(r"finger|gripper|knuckle|jaw|robotiq", re.IGNORECASE)

_FINGER_LINK = "assumed_finger_"
_REACH = 0.12  # of the pads before the flange, along its z axis [m]
_PAD = (0.012, 0.004, 0.015)  # half lengths [m]
_MASS = 0.01  # of a finger: an idle gripper does not count as one that holds [kg]


def commands_gripper(tree: ast.Module | None) -> bool:
    """Return whether a controller names a gripper as an action, a topic, a group or a joint."""
    if tree is None:
        return False
    for node in ast.walk(tree):
        if isinstance(node, ast.alias) and node.name.split(".")[-1] in _COMMANDS:
            return True
        if isinstance(node, ast.Constant) and _NAMED.fullmatch(str(node.value)):
            return True
    return False


def has_assumed_gripper(robot: Robot) -> bool:
    """Return whether the gripper of a robot is one of `with_assumed_gripper`."""
    return any(
        pad.startswith("assumed_") and _FINGER_LINK in pad
        for gripper in robot.grippers
        for pad in gripper.pads
    )


def with_assumed_gripper(robot: Robot, joints: Iterable[str]) -> Robot:
    """Return the robot with a gripper of two fingers on the tip of its longest arm.

    `joints` are those that the controller names; the first two that are called like fingers move
    them. No name is one that the robot has already. Names of groups and states that the controller
    has for it are assumed.
    """
    arms = [group for group in robot.groups.values() if group.tip_link is not None]
    tip = max(arms, key=lambda group: len(group.joints)).tip_link
    assert tip is not None
    taken = {
        robot.base_link,
        *robot.link_names,
        *(attachment.name for attachment in robot.attachments),
    }
    named = tuple(name for name in joints if _FINGER.search(name) and name not in taken)[:2]
    moved = list(named) or [_fresh("gripper_joint", taken)]
    if len(moved) == 1:
        moved.append(_fresh("gripper_second_finger_joint", {*taken, *moved}))
    link = _fresh(_FINGER_LINK, {name.rstrip("0123456789") for name in taken})
    middle = (0.0, 0.0, _REACH)
    pad = Shape("box", _PAD, middle, pad=True)
    hand = sliding_fingers(tuple(moved), tip, link, pad, _MASS, middle)
    group = _fresh(NAME, robot.groups)
    hand = replace(hand, gripper=replace(hand.gripper, group=group))
    drivers = [controller.name for controller in robot.controllers]
    driver = Controller(_fresh("gripper_controller", drivers), "gripper_command", tuple(moved))
    states = {"open": dict.fromkeys(moved, FINGER_OPENING), "close": dict.fromkeys(moved, 0.0)}
    return replace(
        robot,
        links=(*robot.links, *hand.links),
        attachments=(*robot.attachments, *hand.attachments),
        joints=(*robot.joints, *hand.joints),
        groups=MappingProxyType({**robot.groups, group: Group(tuple(moved), tip)}),
        named_states=MappingProxyType({**robot.named_states, group: MappingProxyType(states)}),
        initial_state=MappingProxyType({**robot.initial_state, **states["open"]}),
        grippers=(hand.gripper,),
        controllers=(*robot.controllers, driver),
        approximate=True,
        assumes_names=True,
        chosen_by=f"{robot.chosen_by}; the gripper that the controller speaks of is assumed, on "
        f"'{tip}'",
    )


def _fresh(name: str, taken: Collection[str]) -> str:
    """Return a name that is not taken: this one, else with `assumed_` before it."""
    while name in taken:
        name = f"assumed_{name}"
    return name
