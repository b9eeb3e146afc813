"""The generic arm: for a controller whose robot nobody knows.

It has the joints that the controller names, else as many as it gives positions of, else six.
Planning groups, named states and tool frames that the controller asks for are assumed, and each
assumption is reported.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from types import MappingProxyType

from tracerisk.common.geometry.shapes import Shape
from tracerisk.instrument.source.literals.bounds import whole
from tracerisk.instrument.source.literals.comparisons import is_number
from tracerisk.instrument.source.literals.named_literals import counted_names, literal_value
from tracerisk.twin.robots.outline import derived_servo, outlined
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import (
    DEFAULT_SCALING,
    Attachment,
    Controller,
    Gripper,
    Group,
    Joint,
    Link,
    Servo,
)

NAME = "generic"
_N_JOINTS = 6
_MOST_JOINTS = 9
_FINGERS = 2
_TAKES_JOINTS = frozenset({"go", "set_joint_value_target"})
_NAMES_A_NODE = frozenset({"init_node", "Node", "create_node", "__init__"})
_JOINT = re.compile(r"(?=.*joint)[A-Za-z][A-Za-z0-9_]*(?:\d|_joint|joint_\w+)", re.IGNORECASE)
_NO_JOINT = re.compile(
    r"state|traj|controller|command|name|value|goal|limit|group|position|space|angle|pub|sub|"
    r"target|move|path|servo|action|interface|jog|config|tolerance|vel|topic",
    re.IGNORECASE,
)
_FINGER = re.compile(r"finger|gripper|jaw|claw|hand", re.IGNORECASE)
_FRAME = re.compile(
    r"[A-Za-z][A-Za-z0-9_]*(?:_link\w*|_frame|_tcp|_ee)|tool0|tcp|ee|flange|link_?\d"
)
_BASE = re.compile(r"base|world|odom|map|camera|pedestal|table", re.IGNORECASE)

# A small industrial arm of six axes, elbow up: 0.9 m of reach.
_FRAMES = (
    ((0.0, 0.0, 0.30), (0.0, 0.0, 1.0)),
    ((0.0, 0.0, 0.10), (0.0, 1.0, 0.0)),
    ((0.0, 0.0, 0.40), (0.0, 1.0, 0.0)),
    ((0.15, 0.0, 0.0), (1.0, 0.0, 0.0)),
    ((0.20, 0.0, 0.0), (0.0, 1.0, 0.0)),
    ((0.08, 0.0, 0.0), (1.0, 0.0, 0.0)),
)
_TOOL = (0.10, 0.0, 0.0)
_TORQUES = (150.0, 150.0, 100.0, 30.0, 30.0, 15.0)  # [N m]
_MASSES = (4.0, 5.0, 3.0, 1.5, 1.0, 0.5)  # [kg]
_VELOCITY, _ACCELERATION = 2.0, 2.0
_REST = (0.0, -0.4, 0.6, 0.0, 0.6, 0.0)
FINGER_OPENING = 0.04
"""How far an assumed finger goes from the middle [m]."""


TITLE = "generic arm, for a robot that is not known"


@dataclass(frozen=True, slots=True)
class AxisFigures:
    """What is assumed of one axis of an arm."""

    xyz: tuple[float, float, float]
    """The place of the axis in the frame of the one before it [m]."""
    axis: tuple[float, float, float]
    """The unit vector about which it turns."""
    torque_nm: float
    """The torque limit [N m]."""
    mass_kg: float
    """The mass of the link behind the axis [kg]."""
    speed: float = _VELOCITY
    """The rated speed [rad/s]."""
    range_rad: float = math.pi
    """How far the axis turns to either side [rad]."""


def axis_figures(index: int) -> AxisFigures:
    """Return the figures of an axis, from 0 at the base; further ones turn at the wrist."""
    place = min(index, _N_JOINTS - 1)
    xyz, axis = _FRAMES[place]
    if index >= _N_JOINTS:
        axis = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))[index % 2]
    return AxisFigures(xyz, axis, _TORQUES[place], _MASSES[place])


def is_finger_name(joint: str) -> bool:
    """Return whether a joint is called as those of fingers are."""
    return bool(_FINGER.search(joint))


@dataclass(frozen=True, slots=True)
class NamesAsked:
    """The names of a robot's parts that stand in a controller's source, in their order."""

    joints: tuple[str, ...]
    """The names of joints, fingers among them."""
    frames: tuple[str, ...]
    """The names of links and tool frames."""
    count: int = 0
    """How many joints the arm has by the lists of positions in the source; 0 where none says."""
    wide: frozenset[int] = frozenset()
    """How many numbers the lists have that go beyond half a turn, and not beyond a whole one."""


def names_asked(tree: ast.Module | None) -> NamesAsked:
    """Return what a source names as joints (in lists, or by their look) and as frames.

    A source that cannot be read, and has no tree, names nothing.
    """
    if tree is None:
        return NamesAsked((), ())
    listed = list(_listed(tree))
    strings = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    of_nodes = frozenset(_nodes_named(tree))
    alone = [
        text
        for text in strings
        if _JOINT.fullmatch(text) and not _NO_JOINT.search(text) and text not in of_nodes
    ]
    joints = list(dict.fromkeys(listed or alone))
    frames = [text for text in strings if _FRAME.fullmatch(text) and not _BASE.search(text)]
    return NamesAsked(
        tuple(joints),
        tuple(name for name in dict.fromkeys(frames) if name not in joints),
        _counted_joints(tree),
        frozenset(_wide(tree)),
    )


def _wide(tree: ast.AST) -> Iterator[int]:
    """Yield how many numbers each list has that goes beyond half a turn: joints of an UR do."""
    for node in ast.walk(tree):
        if isinstance(node, ast.List | ast.Tuple) and _FINGERS < len(node.elts) <= _MOST_JOINTS:
            numbers = [value for value in map(literal_value, node.elts) if is_number(value)]
            if len(numbers) == len(node.elts) and math.pi < max(map(abs, numbers)) <= math.tau:
                yield len(numbers)


def _nodes_named(tree: ast.AST) -> Iterator[str]:
    """Yield the names that a source gives its nodes: `joint_mover` is no joint."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _name(node.func) in _NAMES_A_NODE:
            named = [word.value for word in node.keywords if word.arg in ("name", "node_name")]
            for value in (*node.args[:1], *named):
                if isinstance(value, ast.Constant) and isinstance(value.value, str):
                    yield value.value


def _listed(tree: ast.AST) -> Iterator[str]:
    """Yield the names in each list that is given to what is called joints, or looks like them."""
    for node in ast.walk(tree):
        pairs: list[tuple[str, ast.expr]] = []
        if isinstance(node, ast.Assign):
            pairs = [(_name(target), node.value) for target in node.targets]
        elif isinstance(node, ast.keyword):
            pairs = [(node.arg or "", node.value)]
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            pairs = [(_name(node.target), node.value)]
        for name, value in pairs:
            words = _words(value) or list(counted_names(value))
            if not words:
                continue
            if "joint" in name.lower() or all(_JOINT.fullmatch(word) for word in words):
                yield from words


def _counted_joints(tree: ast.AST) -> int:
    """Return how many positions a source gives an arm, or takes of it by their index; 0 for none.

    Two are those of fingers. An index says of an arm that it has so many joints at least.
    """
    longest = furthest = 0
    taken: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call):
            is_taken = _name(node.value.func) == "get_current_joint_values"
            taken |= {_name(target) for target in node.targets} if is_taken else set()
        for value in _given_positions(node):
            count = _length(value)
            longest = max(longest, count if count > _FINGERS else 0)
    for node in ast.walk(tree):
        if isinstance(node, ast.Subscript) and _name(node.value) in taken:
            furthest = max(furthest, (whole(node.slice) or 0) + 1)
    return min(max(longest, furthest if longest or furthest > _N_JOINTS else 0), _MOST_JOINTS)


def _length(value: ast.expr) -> int:
    """Return how many numbers a list holds, also `[0.0] * 7`; 0 for a list of anything else."""
    if isinstance(value, ast.BinOp) and isinstance(value.op, ast.Mult):
        sides = (value.left, value.right), (value.right, value.left)
        return max((whole(times) or 0) * _length(numbers) for numbers, times in sides)
    if not isinstance(value, ast.List | ast.Tuple) or not all(map(_may_be_number, value.elts)):
        return 0
    return len(value.elts)


def _may_be_number(item: ast.expr) -> bool:
    """Return whether an item may be a joint's position: no list, text or object like `Pose()`."""
    if isinstance(item, ast.Constant):
        return isinstance(item.value, int | float)
    if isinstance(item, ast.Call):
        return not _name(item.func)[:1].isupper()
    if isinstance(item, ast.BinOp):
        return _may_be_number(item.left) and _may_be_number(item.right)
    return isinstance(item, ast.UnaryOp | ast.Name | ast.Attribute | ast.Subscript)


def _given_positions(node: ast.AST) -> list[ast.expr]:
    """Return what is given as the positions of joints at one place."""
    if isinstance(node, ast.Call) and _name(node.func) in _TAKES_JOINTS:
        return node.args[:1]
    if isinstance(node, ast.keyword) and node.arg == "positions":
        return [node.value]
    if isinstance(node, ast.Assign):
        return [node.value for target in node.targets if _name(target) == "positions"]
    return []


def _words(value: ast.expr) -> list[str]:
    if not isinstance(value, (ast.List, ast.Tuple)) or not value.elts:
        return []
    words = [
        elt.value
        for elt in value.elts
        if isinstance(elt, ast.Constant)
        and isinstance(elt.value, str)
        and re.fullmatch(r"[A-Za-z]\w*", elt.value)
    ]
    return words if len(words) == len(value.elts) else []


def _name(target: ast.expr) -> str:
    if isinstance(target, ast.Attribute):
        return target.attr
    return target.id if isinstance(target, ast.Name) else ""


def generic_arm(asked: NamesAsked) -> Robot:
    """Return an arm with the joints asked for, else as many as are given, else six; and a gripper.

    It is marked approximate, and as one that assumes groups and states: see `with_assumed_names`.
    """
    fingers = tuple(name for name in asked.joints if _FINGER.search(name))[:2]
    names = tuple(name for name in asked.joints if not _FINGER.search(name))[:_MOST_JOINTS]
    names = names or tuple(f"joint{index + 1}" for index in range(asked.count or _N_JOINTS))
    fingers = fingers or ("gripper_finger_joint",)
    # A shorter arm is the first axes of the longer one.
    axes = [axis_figures(index) for index in range(len(names))]
    if len(names) in asked.wide:
        axes = [replace(axis, range_rad=math.tau) for axis in axes]
    arm_links = [f"generic_link{index + 1}" for index in range(len(names))]
    base = "base_link"
    parents = (base, *arm_links[:-1])
    zero = (0.0, 0.0, 0.0)
    attachments = [
        Attachment(name, "revolute", parent, link, axis.xyz, zero, axis.axis)
        for name, parent, link, axis in zip(names, parents, arm_links, axes, strict=True)
    ]
    joints = [
        Joint(
            name,
            "revolute",
            -axis.range_rad,
            axis.range_rad,
            axis.speed,
            _ACCELERATION,
            axis.torque_nm,
            derived_servo(axis.torque_nm, axis.speed),
        )
        for name, axis in zip(names, axes, strict=True)
    ]
    taken = {base, *arm_links}
    frames = [name for name in asked.frames if name not in taken][:20]
    tool = "tool0" if "tool0" not in frames else "generic_tool"
    attachments.append(_fixed(tool, arm_links[-1], _TOOL))
    attachments += [_fixed(name, tool, zero) for name in frames]
    links = [Link(base, 0.0, zero, None, (Shape("cylinder", (0.08, 0.1), (0, 0, 0.1)),))]
    links += [
        Link(link, axis.mass_kg, zero, None, ()) for link, axis in zip(arm_links, axes, strict=True)
    ]
    links += [Link(name, 0.0, zero, None, ()) for name in (tool, *frames)]
    pad = Shape("box", (0.015, 0.004, 0.01), (0.03, 0.0, 0.0), pad=True)
    hand = sliding_fingers(fingers, tool, "generic_finger", pad, 0.05, zero)
    links += hand.links
    attachments += hand.attachments
    joints += hand.joints
    outlines = [
        outlined(link, 0.04, attachments) if link.name in arm_links else link for link in links
    ]
    rest = {name: _REST[min(index, _N_JOINTS - 1)] for index, name in enumerate(names)}
    groups = {"arm": Group(names, tool), "gripper": Group(fingers, tool)}
    return Robot(
        name=NAME,
        title=TITLE,
        source="assumed: no figure is that of a robot",
        base_link=base,
        links=tuple(outlines),
        attachments=tuple(attachments),
        joints=tuple(joints),
        groups=MappingProxyType(groups),
        named_states=MappingProxyType({}),
        initial_state=MappingProxyType({**rest, **dict.fromkeys(fingers, FINGER_OPENING)}),
        grippers=(hand.gripper,),
        controllers=(
            Controller("arm_controller", "follow_joint_trajectory", names),
            Controller("gripper_controller", "gripper_command", fingers),
        ),
        default_scaling=DEFAULT_SCALING,
        default_scene="empty",
        # Outlines that nobody knows say nothing about which of them meet.
        disabled_collisions=frozenset(combinations(sorted((base, *arm_links)), 2)),
        file="tracerisk/twin/robots/generic.py",
        approximate=True,
        assumes_names=True,
    )


@dataclass(frozen=True, slots=True)
class AssumedHand:
    """A gripper of fingers that slide, with its parts."""

    links: tuple[Link, ...]
    """The links of the fingers."""
    attachments: tuple[Attachment, ...]
    """How the fingers hang on the hand."""
    joints: tuple[Joint, ...]
    """The sliding joints of the fingers."""
    gripper: Gripper
    """The gripper that moves the fingers together."""


def sliding_fingers(
    names: tuple[str, ...],
    base: str,
    link: str,
    pad: Shape,
    mass: float,
    centre: tuple[float, float, float],
) -> AssumedHand:
    """Return a gripper of one or two fingers that slide along y on a base.

    `link` begins the names of the fingers' links, each with one `pad`, which stands aside by half
    its width.
    """
    attachments, links = [], []
    for index, name in enumerate(names):
        side, finger = 1.0 - 2.0 * index, f"{link}{index + 1}"
        x, _, z = pad.xyz
        shape = replace(pad, xyz=(x, side * pad.size[1], z))
        links.append(Link(finger, mass, centre, None, (shape,)))
        zero = (0.0, 0.0, 0.0)
        attachments.append(
            Attachment(name, "prismatic", base, finger, zero, zero, (0.0, side, 0.0))
        )
    joints = [
        Joint(name, "prismatic", 0.0, FINGER_OPENING, 0.2, 1.0, 20.0, Servo(0.0, 0.0, 0.1))
        for name in names
    ]
    count, pads = len(names), tuple(item.name for item in links)
    gripper = Gripper(
        "gripper", "gripper", names, pads, FINGER_OPENING, 20.0, 0.2, 0.05, 500.0 * count,
        20.0 * count, 0.0, (1,) * count,
    )  # fmt: skip
    return AssumedHand(tuple(links), tuple(attachments), tuple(joints), gripper)


def _fixed(child: str, parent: str, xyz: tuple[float, float, float]) -> Attachment:
    return Attachment(
        f"{child}_fixed", "fixed", parent, child, xyz, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    )
