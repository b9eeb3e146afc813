"""A gripper on an arm that is sold without one: that of another shipped robot, or an assumed one.

The user names the other robot's, as in `ur5e+robotiq_2f_85`. Where a controller commands a gripper
that nobody names, every figure of it is assumed.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterable
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.hardware.shipped import ADDED
from tracerisk.errors import RobotError, one_of
from tracerisk.twin.robots.generic import FINGER_OPENING, sliding_fingers
from tracerisk.twin.robots.index import shipped_grippers
from tracerisk.twin.robots.prefix import renamed
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.robots.robot_parts import Controller, Group

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


def words_of_assumed_gripper(robot: Robot) -> str:
    """Return what to say of a robot that has an assumed gripper, and how one is named for it."""
    words = f"the gripper of {robot.name} is assumed with all its figures"
    if robot.name in robot_names():
        words += f"; --robot {robot.name}{ADDED}GRIPPER names it, one of "
        words += ", ".join(shipped_grippers())
    return words


def with_assumed_gripper(robot: Robot, joints: Iterable[str]) -> Robot:
    """Return the robot with a gripper of two fingers on the tip of its longest arm.

    `joints` are those that the controller names; the first two that are called like fingers move
    them. No name is one that the robot has already. Names of groups and states that the controller
    has for it are assumed.
    """
    tip = _tip(robot)
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
        # Drivers of grippers that are bought apart publish no states among those of the arm.
        unpublished=frozenset(moved).difference(named),
        controllers=(*robot.controllers, driver),
        approximate=True,
        assumes_names=True,
        chosen_by=f"{robot.chosen_by}; the gripper that the controller speaks of is assumed, on "
        f"'{tip}'",
    )


def named_robot(name: str) -> Robot:
    """Return the robot of a name: a shipped one, a robot file, or `ARM+GRIPPER`.

    Raises RobotError as `load_robot` and `with_shipped_gripper`.
    """
    arm, added, gripper = name.partition(ADDED)
    if not added or Path(name).suffix:
        return load_robot(name)
    return with_shipped_gripper(load_robot(arm), gripper)


def with_shipped_gripper(robot: Robot, name: str) -> Robot:
    """Return an arm with a gripper of another shipped robot, as that one bears it, on its tip.

    Raises RobotError where no shipped robot has such a gripper, or the arm has one of its own.
    """
    grippers = shipped_grippers()
    whole = f"{robot.name}{ADDED}{name}"
    if name not in grippers:
        raise RobotError(f"{whole}: unknown gripper '{name}'; {one_of(grippers, name)}")
    if robot.grippers:
        raise RobotError(
            f"{whole}: {robot.name} has the gripper {robot.grippers[0].name} already; "
            f"name the robot alone: {robot.name}"
        )
    other = load_robot(grippers[name])
    tip = _tip(robot)
    others_tip = _bearer(other, name)
    links = _hanging_on(other, others_tip)
    hung = [one for one in other.attachments if one.child in links]
    joints = tuple(joint for joint in other.joints if joint.name in {one.name for one in hung})
    moved = {joint.name for joint in joints}
    groups = {key: group for key, group in other.groups.items() if moved.issuperset(group.joints)}
    return replace(
        robot,
        name=whole,
        title=f"{robot.title} with {name}",
        source=f"{robot.source} Gripper: {other.source}",
        links=(*robot.links, *(link for link in other.links if link.name in links)),
        attachments=(
            *robot.attachments,
            *(replace(one, parent=tip) if one.parent == others_tip else one for one in hung),
        ),
        joints=(*robot.joints, *joints),
        groups=MappingProxyType({**robot.groups, **groups}),
        named_states=MappingProxyType(
            {**robot.named_states, **{key: other.named_states.get(key, {}) for key in groups}}
        ),
        initial_state=MappingProxyType(
            {**robot.initial_state, **{key: other.initial_state[key] for key in moved}}
        ),
        grippers=tuple(one for one in other.grippers if one.name == name),
        controllers=(
            *robot.controllers,
            *(one for one in other.controllers if moved.issuperset(one.joints)),
        ),
        disabled_collisions=robot.disabled_collisions.union(
            pair for pair in other.disabled_collisions if links.issuperset(pair)
        ),
        assumes_names=True,
        assumed_figures=(
            *robot.assumed_figures,
            f"{name} is on {tip} as {other.name} bears it, without a coupling",
        ),
    )


def with_named_gripper(robot: Robot, joints: Iterable[str]) -> Robot | None:
    """Return an arm with the shipped gripper of which a controller names a joint, else None.

    It is None, too, where the arm has a link or joint of the same name.
    """
    names = frozenset(joints)
    for name, bearer in shipped_grippers().items():
        own = next(one for one in load_robot(bearer).grippers if one.name == name).joints
        named = next((joint for joint in own if joint in names), None)
        if named is None:
            continue
        borne = replace(with_shipped_gripper(robot, name), name=robot.name)
        parts = [*borne.link_names, *(one.name for one in borne.attachments)]
        if len({*parts}) < len(parts):
            return None
        return replace(
            borne,
            chosen_by=f"{robot.chosen_by}; its gripper is {name}, whose joint {named} the "
            "controller names",
        )
    return None


def with_finger_joint(robot: Robot, joints: Iterable[str]) -> Robot:
    """Return a robot with an added gripper whose joint has the name that a controller has for it.

    `joints` are those that the controller names; the first that is called like a finger is meant,
    unless the robot has it.
    """
    known = {joint.name for joint in robot.joints}
    named = [name for name in joints if _FINGER.search(name)]
    if not named or not known.isdisjoint(named):
        return robot
    own = robot.grippers[0].joints[0]
    return renamed(robot, lambda name: named[0] if name == own else name)


def _tip(robot: Robot) -> str:
    """Return the link at the tip of the longest arm of a robot."""
    arms = [group for group in robot.groups.values() if group.tip_link is not None]
    tip = max(arms, key=lambda group: len(group.joints)).tip_link
    assert tip is not None
    return tip


def _bearer(robot: Robot, gripper: str) -> str:
    """Return the frame of an arm on which a gripper is screwed: a link without mass and shape."""
    pad = next(one for one in robot.grippers if one.name == gripper).pads[0]
    frames = {link.name for link in robot.links if not link.shapes and link.mass == 0.0}
    return next(one.parent for one in robot.above(pad) if one.parent in frames)


def _hanging_on(robot: Robot, link: str) -> frozenset[str]:
    """Return the links that hang on a link, directly or not."""
    return frozenset(
        own.name
        for own in robot.links
        if own.name != link and any(one.parent == link for one in robot.above(own.name))
    )


def _fresh(name: str, taken: Collection[str]) -> str:
    """Return a name that is not taken: this one, else with `assumed_` before it."""
    while name in taken:
        name = f"assumed_{name}"
    return name
