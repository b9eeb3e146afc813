"""The generic arm: for a controller whose robot nobody knows.

It has the joints that the controller names, else six. Planning groups, named states and tool
frames that the controller asks for are assumed, and each assumption is told.
"""

from __future__ import annotations

import ast
import hashlib
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from types import MappingProxyType

from tracerisk.twin.outline import derived_servo, outlined
from tracerisk.twin.robot import (
    DEFAULT_SCALING,
    Attachment,
    Controller,
    Gripper,
    Group,
    Joint,
    Link,
    Robot,
    Servo,
)
from tracerisk.twin.shapes import Shape

NAME = "generic"
_N_JOINTS = 6
_MOST_JOINTS = 9
_JOINT = re.compile(r"(?=.*joint)[A-Za-z][A-Za-z0-9_]*(?:\d|_joint|joint_\w+)", re.IGNORECASE)
_NO_JOINT = re.compile(
    r"state|traj|controller|command|name|value|goal|limit|group|position|space|angle|pub|sub|"
    r"target|move|path|servo|action|interface|jog|config|tolerance|vel|topic",
    re.IGNORECASE,
)
_FINGER = re.compile(r"finger|gripper|jaw|claw|hand", re.IGNORECASE)
_HAND = re.compile(r"gripper|hand|finger|claw|end_?effector", re.IGNORECASE)
_FRAME = re.compile(
    r"[A-Za-z][A-Za-z0-9_]*(?:_link\w*|_frame|_tcp|_ee)|tool0|tcp|ee|flange|link_?\d"
)
_BASE = re.compile(r"base|world|odom|map|camera|pedestal|table", re.IGNORECASE)
_OPENS = re.compile(r"open|release", re.IGNORECASE)
_CLOSES = re.compile(r"clos|grasp|grip", re.IGNORECASE)

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
_SLIP = 0.8  # how alike two names of a group are of which one is taken for a misspelling
_SHARE = 0.12  # of its range, how far an assumed state is from rest at most


@dataclass(frozen=True, slots=True)
class NamesAsked:
    """The names of a robot's parts that stand in a controller's source, in their order."""

    joints: tuple[str, ...]
    frames: tuple[str, ...]


def names_asked(source: bytes) -> NamesAsked:
    """Return what a source names as joints (in lists, or by their look) and as frames.

    A source that is no Python names nothing.
    """
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return NamesAsked((), ())
    listed = list(_listed(tree))
    strings = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    alone = [text for text in strings if _JOINT.fullmatch(text) and not _NO_JOINT.search(text)]
    joints = list(dict.fromkeys(listed or alone))
    frames = [text for text in strings if _FRAME.fullmatch(text) and not _BASE.search(text)]
    return NamesAsked(
        tuple(joints), tuple(name for name in dict.fromkeys(frames) if name not in joints)
    )


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
            words = _words(value)
            if not words:
                continue
            if "joint" in name.lower() or all(_JOINT.fullmatch(word) for word in words):
                yield from words


def _words(value: ast.expr) -> list[str]:
    if not isinstance(value, (ast.List, ast.Tuple)) or not value.elts:
        return []
    words = [
        each.value
        for each in value.elts
        if isinstance(each, ast.Constant)
        and isinstance(each.value, str)
        and re.fullmatch(r"[A-Za-z]\w*", each.value)
    ]
    return words if len(words) == len(value.elts) else []


def _name(target: ast.expr) -> str:
    if isinstance(target, ast.Attribute):
        return target.attr
    return target.id if isinstance(target, ast.Name) else ""


def generic_arm(asked: NamesAsked) -> Robot:
    """Return an arm with the joints asked for, else with six, and with a gripper.

    It is marked approximate, and as one that assumes groups and states: see `with_assumed_names`.
    """
    fingers = tuple(name for name in asked.joints if _FINGER.search(name))[:2]
    names = tuple(name for name in asked.joints if not _FINGER.search(name))[:_MOST_JOINTS]
    names = names or tuple(f"joint{index + 1}" for index in range(_N_JOINTS))
    fingers = fingers or ("gripper_finger_joint",)
    count = len(names)
    # A shorter arm is the first axes of the longer one; further ones turn at its wrist.
    places = [min(index, _N_JOINTS - 1) for index in range(count)]
    arm_links = [f"generic_link{index + 1}" for index in range(count)]
    base = "base_link"
    attachments = [
        Attachment(
            name,
            "revolute",
            base if index == 0 else arm_links[index - 1],
            arm_links[index],
            _FRAMES[place][0],
            (0.0, 0.0, 0.0),
            _FRAMES[place][1] if index < _N_JOINTS else ((1.0, 0, 0), (0, 1.0, 0))[index % 2],
        )
        for index, (name, place) in enumerate(zip(names, places, strict=True))
    ]
    joints = [
        Joint(
            name,
            "revolute",
            -math.pi,
            math.pi,
            _VELOCITY,
            _ACCELERATION,
            _TORQUES[place],
            derived_servo(_TORQUES[place], _VELOCITY),
        )
        for name, place in zip(names, places, strict=True)
    ]
    taken = {base, *arm_links}
    frames = [name for name in asked.frames if name not in taken][:20]
    tool = "tool0" if "tool0" not in frames else "generic_tool"
    attachments.append(_fixed(tool, arm_links[-1], _TOOL))
    attachments += [_fixed(name, tool, (0.0, 0.0, 0.0)) for name in frames]
    links = [Link(base, 0.0, (0.0, 0.0, 0.0), None, (Shape("cylinder", (0.08, 0.1), (0, 0, 0.1)),))]
    links += [
        Link(link, _MASSES[place], (0.0, 0.0, 0.0), None, ())
        for link, place in zip(arm_links, places, strict=True)
    ]
    links += [Link(name, 0.0, (0.0, 0.0, 0.0), None, ()) for name in (tool, *frames)]
    for index, name in enumerate(fingers):
        side = 1.0 - 2.0 * index
        link = f"generic_finger{index + 1}"
        attachments.append(
            Attachment(
                name, "prismatic", tool, link, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, side, 0.0)
            )
        )
        pad = Shape("box", (0.015, 0.004, 0.01), (0.03, side * 0.004, 0.0), pad=True)
        links.append(Link(link, 0.05, (0.0, 0.0, 0.0), None, (pad,)))
        joints.append(Joint(name, "prismatic", 0.0, 0.04, 0.2, 1.0, 20.0, Servo(0.0, 0.0, 0.1)))
    outlines = [
        outlined(link, 0.04, attachments) if link.name in arm_links else link for link in links
    ]
    rest = {name: _REST[place] for name, place in zip(names, places, strict=True)}
    groups = {
        "arm": Group(names, tool),
        "gripper": Group(fingers, tool),
    }
    gripper = Gripper(
        "gripper", "gripper", fingers, tuple(f"generic_finger{i + 1}" for i in range(len(fingers))),
        0.04, 20.0, 0.2, 0.05, 500.0 * len(fingers), 20.0 * len(fingers), 0.0, (1,) * len(fingers),
    )  # fmt: skip
    return Robot(
        name=NAME,
        title="generic arm, for a robot that is not known",
        source="assumed: no figure is that of a robot",
        base_link=base,
        links=tuple(outlines),
        attachments=tuple(attachments),
        joints=tuple(joints),
        groups=MappingProxyType(groups),
        named_states=MappingProxyType({}),
        initial_state=MappingProxyType({**rest, **dict.fromkeys(fingers, 0.04)}),
        grippers=(gripper,),
        controllers=(
            Controller("arm_controller", "follow_joint_trajectory", names),
            Controller("gripper_controller", "gripper_command", fingers),
        ),
        default_scaling=DEFAULT_SCALING,
        default_scene="empty",
        file="tracerisk/twin/generic.py",
        approximate=True,
        assumes_names=True,
    )


def _fixed(child: str, parent: str, xyz: tuple[float, float, float]) -> Attachment:
    return Attachment(
        f"{child}_fixed", "fixed", parent, child, xyz, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    )


def with_assumed_names(robot: Robot, tell: Callable[[str], None]) -> Robot:
    """Return a robot that assumes the groups and states asked of it, and tells each one once.

    A robot that does not assume names is returned as it is.
    """
    if not robot.assumes_names:
        return robot
    groups = _AssumedGroups(robot, tell)
    return replace(robot, groups=groups, named_states=_AssumedStates(robot, groups, tell))


def _remedy(robot: Robot) -> str:
    if robot.name == NAME:
        return "name the robot with --robot"
    return "an SRDF beside its file would tell"


class _AssumedGroups(Mapping[str, Group]):
    """The groups of a robot; any other name is the arm, or the gripper if it sounds like one."""

    def __init__(self, robot: Robot, tell: Callable[[str], None]) -> None:
        self._known = dict(robot.groups)
        self._robot = robot
        self._tell = tell

    def __getitem__(self, name: str) -> Group:
        if name not in self._known:
            stand_in = self.stand_in(name)
            self._known[name] = self._known[stand_in]
            self._tell(
                f"planning group '{name}' is assumed to be the {stand_in} of the {self._robot.name}"
                f" robot, for it is not known; {_remedy(self._robot)}"
            )
        return self._known[name]

    def stand_in(self, name: str) -> str:
        """Return which known group stands for one of another name."""
        grippers = [gripper.group for gripper in self._robot.grippers]
        if grippers and _HAND.search(name) and "arm" not in name.lower():
            return grippers[0]
        fingers = {joint for gripper in self._robot.grippers for joint in gripper.joints}
        groups = self._robot.groups
        arms = [name for name in groups if name not in grippers]
        # An arm with its hand has no tip to which a pose could be asked for.
        plain = [name for name in arms if fingers.isdisjoint(groups[name].joints)]
        return max(plain or arms, key=lambda each: len(groups[each].joints))

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and bool(name) and not self._is_slip(name)

    def _is_slip(self, name: str) -> bool:
        """Say whether a name is a known one with a slip of the pen, which must not be assumed."""
        near = get_close_matches(name, self._robot.groups, n=1, cutoff=_SLIP)
        if not near or name in self._known:
            return False
        return name not in near[0] and near[0] not in name

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._known))

    def __len__(self) -> int:
        return len(self._known)


class _AssumedStates(Mapping[str, Mapping[str, Mapping[str, float]]]):
    """For each group, named states of any name."""

    def __init__(self, robot: Robot, groups: _AssumedGroups, tell: Callable[[str], None]) -> None:
        self._robot = robot
        self._groups = groups
        self._tell = tell
        self._states: dict[str, _StatesOfGroup] = {}

    def __getitem__(self, group: str) -> Mapping[str, Mapping[str, float]]:
        if group not in self._states:
            states = self._robot.named_states
            known = states.get(group) or states.get(self._groups.stand_in(group), {})
            members = self._groups[group].joints
            self._states[group] = _StatesOfGroup(self._robot, group, members, known, self._tell)
        return self._states[group]

    def __contains__(self, group: object) -> bool:
        return group in self._groups

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._groups))

    def __len__(self) -> int:
        return len(self._groups)


class _StatesOfGroup(Mapping[str, Mapping[str, float]]):
    def __init__(
        self,
        robot: Robot,
        group: str,
        joints: Iterable[str],
        known: Mapping[str, Mapping[str, float]],
        tell: Callable[[str], None],
    ) -> None:
        self._robot = robot
        self._group = group
        self._joints = tuple(joints)
        self._known = dict(known)
        self._tell = tell

    def __getitem__(self, name: str) -> Mapping[str, float]:
        if name not in self._known:
            self._known[name] = {joint: self._position(joint, name) for joint in self._joints}
            self._tell(
                f"named state '{name}' of group '{self._group}' is not known: a posture is "
                f"assumed; {_remedy(self._robot)}"
            )
        return self._known[name]

    def _position(self, joint: str, state: str) -> float:
        """Return a position that is the same in every run: near rest, another for each name."""
        own = self._robot.joint(joint)
        rest = self._robot.initial_state[joint]
        for gripper in self._robot.grippers:
            if joint in gripper.joints and (_OPENS.search(state) or _CLOSES.search(state)):
                return own.upper if _OPENS.search(state) else max(own.lower, min(0.0, own.upper))
        if re.fullmatch(r"home|rest|zero|init\w*", state, re.IGNORECASE):
            return rest
        draw = hashlib.sha256(f"{state}\x00{joint}".encode()).digest()[0] / 255 * 2 - 1
        wanted = rest + draw * _SHARE * (own.upper - own.lower)
        return min(max(wanted, own.lower), own.upper)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and bool(name)

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._known))

    def __len__(self) -> int:
        return len(self._known)
