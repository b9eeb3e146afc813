"""Assumed planning groups and named states of a robot; each is an assumption of the run."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches

from tracerisk.common.text.digests import sha256
from tracerisk.twin.robots.generic import NAME
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Group

HAND = re.compile(r"gripper|hand|finger|claw|end_?effector", re.IGNORECASE)
"""What a group of a gripper is called, rather than one of an arm."""
_OPENS = re.compile(r"open|release", re.IGNORECASE)
_CLOSES = re.compile(r"clos|grasp|grip", re.IGNORECASE)
_SLIP = 0.8  # how alike two names of a group are of which one is taken for a misspelling
_OF_CONTROLLER = re.compile(r"(_joint)?(_trajectory|_position)?_controller$")
_SHARE = 0.12  # of its range, how far an assumed state is from rest at most


Controllers = Callable[[], Mapping[str, tuple[str, ...]]]
"""Returns the joints of each controller that the workspace declares, by the controller's name."""


def with_assumed_names(
    robot: Robot, report: Callable[[str], None], controllers: Controllers = dict
) -> Robot:
    """Return a robot that assumes the groups and states asked of it, and reports each one once.

    A robot that does not assume names is returned as it is.
    """
    if not robot.assumes_names:
        return robot
    groups = _AssumedGroups(robot, report, controllers)
    return replace(robot, groups=groups, named_states=_AssumedStates(robot, groups, report))


def _remedy(robot: Robot) -> str:
    if robot.name == NAME:
        return "name the robot with --robot"
    return "an SRDF beside its file would define it"


class _AssumedGroups(Mapping[str, Group]):
    """The groups of a robot; any other name is the arm, or the gripper if it sounds like one."""

    def __init__(
        self, robot: Robot, report: Callable[[str], None], controllers: Controllers
    ) -> None:
        self._known = dict(robot.groups)
        self._robot = robot
        self._report = report
        self._controllers = controllers

    def __getitem__(self, name: str) -> Group:
        if name not in self._known:
            stand_in = self.stand_in(name)
            self._known[name], taken = self._known[stand_in], f"group {stand_in}"
            declared = self._declared(name)
            if declared is not None and {*declared[1]} != {*self._known[name].joints}:
                self._known[name] = _group_of(self._robot, declared[1])
                taken = f"the joints of controller {declared[0]}"
            self._report(
                f"unknown planning group '{name}'; using {taken} of {self._robot.name}; "
                f"{_remedy(self._robot)}"
            )
        return self._known[name]

    def _declared(self, name: str) -> tuple[str, tuple[str, ...]] | None:
        """Return the workspace's controller for a group of an arm, with its joints; else None.

        It is called as the group is, or the only one that moves several joints of the arm.
        """
        if self._is_hand(name):
            return None
        arm = {joint.name for joint in self._robot.arm_joints}
        declared = [
            (controller, joints)
            for controller, joints in self._controllers().items()
            if len(joints) > 1 and arm.issuperset(joints)
        ]
        own = [pair for pair in declared if _OF_CONTROLLER.sub("", pair[0]) == name]
        is_one = len({frozenset(joints) for _, joints in declared}) == 1
        return own[0] if own else declared[0] if is_one else None

    def _is_hand(self, name: str) -> bool:
        return bool(self._robot.grippers) and bool(HAND.search(name)) and "arm" not in name.lower()

    def stand_in(self, name: str) -> str:
        """Return which known group stands for one of another name."""
        grippers = [gripper.group for gripper in self._robot.grippers]
        if self._is_hand(name):
            return grippers[0]
        fingers = {joint for gripper in self._robot.grippers for joint in gripper.joints}
        groups = self._robot.groups
        arms = [name for name in groups if name not in grippers]
        # An arm with its hand has no tip to which a pose could be asked for.
        plain = [name for name in arms if fingers.isdisjoint(groups[name].joints)]
        # Where every group is a gripper's, as of a tool on a table, one of them is what moves.
        return max(plain or arms or groups, key=lambda arm: len(groups[arm].joints))

    def __contains__(self, name: object) -> bool:
        if not self._robot.groups:
            return False
        return isinstance(name, str) and bool(name) and not self._is_slip(name)

    def _is_slip(self, name: str) -> bool:
        """Return whether a name is a misspelt known one, which must not be assumed."""
        near = get_close_matches(name, self._robot.groups, n=1, cutoff=_SLIP)
        if not near or name in self._known:
            return False
        return name not in near[0] and near[0] not in name

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._known))

    def __len__(self) -> int:
        return len(self._known)


def _group_of(robot: Robot, joints: tuple[str, ...]) -> Group:
    """Return a group of joints, whose tip is what hangs rigidly on the last of them."""
    order = [attachment.name for attachment in robot.attachments]
    names = tuple(sorted(joints, key=order.index))
    ways = {
        attachment.name: [above.name for above in robot.above(attachment.child)]
        for attachment in robot.attachments
        if attachment.name in names
    }
    last = max(names, key=lambda joint: len(ways[joint]))
    if not {*names} <= {*ways[last]}:
        return Group(names, None)
    tip = next(attachment.child for attachment in robot.attachments if attachment.name == last)
    while True:
        below = [attachment for attachment in robot.attachments if attachment.parent == tip]
        if len(below) != 1 or below[0].type != "fixed":
            return Group(names, tip)
        tip = below[0].child


class _AssumedStates(Mapping[str, Mapping[str, Mapping[str, float]]]):
    """For each group, named states of any name."""

    def __init__(self, robot: Robot, groups: _AssumedGroups, report: Callable[[str], None]) -> None:
        self._robot = robot
        self._groups = groups
        self._report = report
        self._states: dict[str, _StatesOfGroup] = {}

    def __getitem__(self, group: str) -> Mapping[str, Mapping[str, float]]:
        if group not in self._states:
            states = self._robot.named_states
            known = dict(states.get(group) or states.get(self._groups.stand_in(group), {}))
            members = self._groups[group].joints
            self._states[group] = _StatesOfGroup(self._robot, group, members, known, self._report)
        return self._states[group]

    def __contains__(self, group: object) -> bool:
        return group in self._groups

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._groups))

    def __len__(self) -> int:
        return len(self._groups)


@dataclass(eq=False)
class _StatesOfGroup(Mapping[str, Mapping[str, float]]):
    _robot: Robot
    """The robot whose states are assumed."""
    _group: str
    """The name of the planning group, for messages."""
    _joints: tuple[str, ...]
    """The names of the group's joints."""
    _known: dict[str, Mapping[str, float]]
    """The joint positions of each known or assumed state [rad or m]."""
    _report: Callable[[str], None]
    """Receives a sentence for each state that is assumed."""

    def __getitem__(self, name: str) -> Mapping[str, float]:
        if name not in self._known:
            self._known[name] = {joint: self._position(joint, name) for joint in self._joints}
            self._report(
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
                ends = gripper_ends(self._robot, gripper)
                end = ends.opened if _OPENS.search(state) else ends.closed
                return gripper.sign(joint) * end
        if re.fullmatch(r"home|rest|zero|init\w*", state, re.IGNORECASE):
            return rest
        draw = int(sha256(f"{state}\x00{joint}".encode())[:2], 16) / 255 * 2 - 1
        wanted = rest + draw * _SHARE * (own.upper - own.lower)
        return min(max(wanted, own.lower), own.upper)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and bool(name)

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._known))

    def __len__(self) -> int:
        return len(self._known)
