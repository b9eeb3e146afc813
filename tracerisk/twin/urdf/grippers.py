"""Find the grippers in a URDF: joints that move fingers, together and behind all others."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tracerisk.common.geometry.frames import rotation
from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.robots.robot_parts import Gripper, Group, Joint, Link, Servo
from tracerisk.twin.urdf.srdf import EndEffector, Srdf
from tracerisk.twin.urdf.tree import Tree, UrdfJoint

_FINGER = re.compile(r"finger|gripper|jaw|knuckle|claw|thumb|mors|pinch", re.IGNORECASE)
_FINGER_LINK = re.compile(r"finger|jaw|knuckle|claw|thumb|mors", re.IGNORECASE)
_TOOL = re.compile(r"tool|tcp|flange|end_?effector|(?:^|_)eef?(?:_|$)", re.IGNORECASE)
_TURNS_A_HAND = re.compile(r"roll|pitch|yaw|rot|wrist", re.IGNORECASE)
_TRAVEL = {"prismatic": 0.03, "revolute": 0.8, "continuous": 0.8}  # where the file gives none
_EFFORT = {"prismatic": (5.0, 100.0), "revolute": (0.5, 10.0)}  # least, greatest [N or N m]
_SETTLES_S = 0.04  # damping by stiffness
_MOST_FINGERS = 5  # of a hand whose fingers slide
_LONGEST_WAY = 0.25  # assumed of a finger that slides and is not called one [m]
_MEETING = 0.1  # how long the sum of unit vectors may be that are to cancel
_PAD = (0.01, 0.01, 0.015)  # half lengths of a pad whose finger is a mesh [m]


@dataclass(frozen=True, slots=True)
class GripperParts:
    """The joints of a gripper and their group."""

    name: str
    """The name of the gripper, equal to that of its group."""
    group: str
    """The planning group that moves the joints."""
    joints: tuple[str, ...]
    """The names of the joints, the leading one first."""


def is_finger(joint: UrdfJoint, tree: Tree) -> bool:
    """Return whether a joint moves a finger: by its name, or as one of several that meet.

    Whatever carries a joint of another kind is not a finger, nor is what carries several that
    move by themselves: that turns the whole hand.
    """
    return (
        joint.moves
        and _looks_so(joint, tree)
        and all(_looks_so(mover, tree) for mover in tree.movers_below(joint.child))
        and not _carries_a_hand(joint, tree)
    )


def _carries_a_hand(joint: UrdfJoint, tree: Tree) -> bool:
    """Return whether several fingers, none of which moves with the joint, are fixed behind it."""
    nearest = [
        mover
        for mover in tree.movers_below(joint.child)
        if not any(between.moves for between in tree.way(mover.parent, joint.child))
    ]
    return len(nearest) > 1 and len(_linkage(joint, tree)) == 1


def _looks_so(joint: UrdfJoint, tree: Tree) -> bool:
    if _TURNS_A_HAND.search(joint.name):
        return False
    if _FINGER.search(joint.name) or _FINGER_LINK.search(joint.child):
        return True
    together = _linkage(joint, tree)
    if len(together) > 1:
        return _is_hand(together, tree)
    return joint.type == "prismatic" and _close_on_each_other(joint, tree)


def _close_on_each_other(joint: UrdfJoint, tree: Tree) -> bool:
    """Return whether what slides on a joint's parent are fingers: short ways that meet.

    They open to as many sides, as two opposite ones do, or three all round. Where a range goes as
    far to both sides, or is missing, a joint may open to either: so only where an arm carries it.
    """
    sliders = [
        urdf_joint
        for urdf_joint in tree.below(joint.parent)
        if urdf_joint.moves
        and urdf_joint.type == "prismatic"
        and not any(tree.movers_below(urdf_joint.child))
    ]
    if joint not in sliders or not 2 <= len(sliders) <= _MOST_FINGERS:
        return False
    if any(slider.upper - slider.lower > _LONGEST_WAY for slider in sliders):
        return False
    sides = [float(np.sign(slider.lower + slider.upper)) for slider in sliders]
    if not all(sides) and not _carrier(joint, tree):
        return False
    along = [rotation(slider.rpy) @ slider.axis / np.linalg.norm(slider.axis) for slider in sliders]
    choices = itertools.product(*((side,) if side else (1.0, -1.0) for side in sides))
    return any(bool(np.linalg.norm(np.dot(choice, along)) < _MEETING) for choice in choices)


def _linkage(joint: UrdfJoint, tree: Tree) -> frozenset[str]:
    """Return the joints that move as one with a joint, itself included: who mimics whom."""
    linked = {joint.name}
    pairs = [
        (urdf_joint.name, urdf_joint.mimic[0])
        for urdf_joint in tree.moving
        if urdf_joint.mimic is not None
    ]
    for _ in pairs:
        more = {name for pair in pairs if linked & set(pair) for name in pair}
        if more <= linked:
            break
        linked |= more
    return frozenset(name for name in linked if tree.joint(name) is not None)


def _is_hand(together: frozenset[str], tree: Tree) -> bool:
    """Return whether joints that move as one are fingers: equal branches, side by side.

    Of an arm, one joint may lead the rods of a parallelogram and the joint that levels a tool.
    Then a branch begins further out than another, has other joints behind it, has fewer joints
    than another, or carries the tool.
    """
    members = [joint for joint in tree.moving if joint.name in together]
    roots = [joint for joint in members if not _names_on(joint.parent, tree) & together]
    carriers = {_carrier(joint, tree) for joint in roots}
    branches = [[joint.name, *(mover.name for mover in tree.movers_below(joint.child))]
                for joint in roots]  # fmt: skip
    if len(roots) < 2 or len(carriers) > 1 or len({len(branch) for branch in branches}) > 1:
        return False
    if any(not together.issuperset(branch) for branch in branches):
        return False
    links = {urdf_joint.child for joint in roots for urdf_joint in _hanging_on(joint.child, tree)}
    return not any(_TOOL.search(link) for link in links)


def _names_on(link: str, tree: Tree) -> frozenset[str]:
    """Return the joints on the way to a link."""
    return frozenset(joint.name for joint in tree.way(link))


def _carrier(joint: UrdfJoint, tree: Tree) -> str:
    """Return the last joint before one that moves, an empty name at the base."""
    return next(
        (urdf_joint.name for urdf_joint in reversed(tree.way(joint.parent)) if urdf_joint.moves), ""
    )


def _hanging_on(link: str, tree: Tree) -> Iterator[UrdfJoint]:
    for joint in tree.below(link):
        yield joint
        yield from _hanging_on(joint.child, tree)


def grippers_of(
    tree: Tree,
    srdf: Srdf | None,
    groups: Mapping[str, Group],
    known: Collection[str] = (),
) -> tuple[GripperParts, ...]:
    """Return the grippers: those of the end effectors, and what else looks like fingers.

    `known` are joints that are fingers whatever their names. Fingers behind the same joint of the
    arm are one gripper. A joint that carries the link to which an end effector is fixed is of the
    arm, though the effector's group has it, too. A group that has that link itself is no hand.
    """
    wanted = {
        name
        for effector in (srdf.end_effectors if srdf is not None else ())
        if effector.group in groups and not _is_arm(effector, srdf, tree)
        for name in (*groups[effector.group].joints, *_followers(groups[effector.group], tree))
        if name not in {joint.name for joint in tree.way(effector.parent_link)}
    }
    wanted |= set(known)
    fingers = [
        joint
        for joint in tree.moving
        if is_finger(joint, tree)
        or (joint.name in wanted and all(j.name in wanted for j in tree.movers_below(joint.child)))
    ]
    names = {joint.name for joint in fingers}
    hands: dict[str, list[UrdfJoint]] = {}
    for joint in fingers:
        carrying = [
            urdf_joint.name
            for urdf_joint in tree.way(joint.parent)
            if urdf_joint.moves and urdf_joint.name not in names
        ]
        hands.setdefault(carrying[-1] if carrying else "", []).append(joint)
    grippers: list[GripperParts] = []
    for hand in hands.values():
        leaders = {urdf_joint.mimic[0] for urdf_joint in hand if urdf_joint.mimic}
        ordered = sorted(
            hand,
            key=lambda urdf_joint: (urdf_joint.mimic is not None, urdf_joint.name not in leaders),
        )
        joints = tuple(joint.name for joint in ordered)
        group = _group(joints, groups) or _fresh("gripper", {*groups, *(p.group for p in grippers)})
        grippers.append(GripperParts(group, group, joints))
    return tuple(grippers)


def _is_arm(effector: EndEffector, srdf: Srdf | None, tree: Tree) -> bool:
    """Return whether an end effector is an arm: its group has its parent link, which stands still.

    The link that carries an end effector should not be one of its own group (moveit/moveit,
    `moveit_setup_assistant/src/widgets/end_effectors_widget.cpp`); MoveIt takes such a file all
    the same, and moves the group as an arm.
    """
    link = effector.parent_link
    if any(joint.moves for joint in tree.way(link)):
        return False
    groups = srdf.groups if srdf is not None else ()
    named = next((group for group in groups if group.name == effector.group), None)
    if named is None:
        return False
    return link in named.links or any(base == link for base, _ in named.chains)


def _followers(group: Group, tree: Tree) -> Iterator[str]:
    """Yield the joints of a group that follow another one, which its own joints leave out."""
    members = (tree.joint(name) for name in group.members)
    return (joint.name for joint in members if joint is not None and joint.moves and joint.mimic)


def _group(joints: tuple[str, ...], groups: Mapping[str, Group]) -> str | None:
    """Return the largest group that moves nothing but these joints."""
    fitting = [name for name, group in groups.items() if set(group.joints) <= set(joints)]
    return max(fitting, key=lambda name: len(groups[name].joints), default=None)


def _fresh(name: str, taken: set[str]) -> str:
    index = 1
    fresh = name
    while fresh in taken:
        index += 1
        fresh = f"{name}_{index}"
    return fresh


def built_gripper(
    parts: GripperParts, joints: Mapping[str, Joint], tree: Tree
) -> tuple[Gripper, dict[str, Joint]]:
    """Return the gripper and its joints, which all travel as far as the one that leads."""
    lead = joints[parts.joints[0]]
    kind = "prismatic" if lead.type == "prismatic" else "revolute"
    lower, upper = lead.lower, lead.upper
    if upper - lower > 2 * math.pi * 0.9 or upper - lower < 1e-4:
        lower, upper = 0.0, _TRAVEL[kind]
    least, most = _EFFORT[kind]
    effort = min(max(lead.torque_limit, least), most)
    signs = tuple(_sign(name, parts, joints, tree) for name in parts.joints)
    fingers = {
        name: replace(
            joints[name],
            type="prismatic" if joints[name].type == "prismatic" else "revolute",
            lower=lower if sign > 0 else -upper,
            upper=upper if sign > 0 else -lower,
            velocity_limit=lead.velocity_limit,
            torque_limit=effort,
            servo=Servo(
                0.0,
                0.0,
                0.1 if kind == "prismatic" else 0.005,
                1.0 if kind == "prismatic" else 0.02,
            ),
        )
        for name, sign in zip(parts.joints, signs, strict=True)
    }
    stiffness = len(parts.joints) * effort / (upper - lower)
    gripper = Gripper(
        name=parts.name,
        group=parts.group,
        joints=parts.joints,
        pads=_pads(parts, tree),
        opening=upper,
        effort=effort,
        velocity_limit=lead.velocity_limit,
        speed=lead.velocity_limit / 2,
        stiffness=stiffness,
        damping=_SETTLES_S * stiffness,
        least=lower,
        signs=signs,
    )
    return gripper, fingers


def _sign(name: str, parts: GripperParts, joints: Mapping[str, Joint], tree: Tree) -> int:
    lead = parts.joints[0]
    joint = tree.joint(name)
    sign = 1.0
    # A finger may follow one that follows the leader.
    for _ in parts.joints:
        if joint is None or joint.name == lead or joint.mimic is None:
            break
        sign *= joint.mimic[1]
        joint = tree.joint(joint.mimic[0])
    if joint is not None and joint.name != lead and joint.name in joints:
        own, first = joints[joint.name], joints[lead]
        sign *= (own.lower + own.upper) * (first.lower + first.upper) or 1.0
    return -1 if sign < 0 else 1


def _pads(parts: GripperParts, tree: Tree) -> tuple[str, ...]:
    """Return the outermost links that the joints move."""
    moved = {tree.joint(name): name for name in parts.joints}
    return tuple(
        joint.child
        for joint in moved
        if joint is not None and not any(True for _ in tree.movers_below(joint.child))
    )


def padded(link: Link) -> Link:
    """Return a finger with one shape that is its pad: its last one, else a box at its middle."""
    if any(shape.pad for shape in link.shapes):
        return link
    solid = [shape for shape in link.shapes if shape.kind == "box"]
    if solid:
        rest = tuple(shape for shape in link.shapes if shape is not solid[-1])
        return replace(link, shapes=(*rest, replace(solid[-1], pad=True)))
    return replace(
        link, shapes=(*link.shapes, Shape("box", _PAD, xyz=link.centre_of_mass, pad=True))
    )
