"""Find the robot that a controller speaks of, from the strings in its source."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import PurePath

from tracerisk.errors import RobotError, one_of
from tracerisk.twin.robot import Robot, load_robot, robot_names

# What many robots call a part of theirs says nothing about which one it is.
_COMMON = {
    "arm", "arm_controller", "base_link", "base_footprint", "ee_link", "end_effector_link",
    "gripper", "gripper_controller", "gripper_link", "hand", "head", "joint_trajectory_controller",
    "manipulator", "tool0", "tool_link", "world",
}  # fmt: skip
_SHORTEST_STEM = 5  # `joint` alone says nothing about the arm
_Evidence = tuple[int, int, int]


class NoRobotNamedError(RobotError):
    """The controller's strings speak of no known robot."""


def detect_robot(strings: Iterable[str], place: str = "") -> Robot:
    """Return the robot whose joints, links or groups the strings name.

    A string counts as a whole, as a part of a ROS name (`/panda_arm_controller/command`), or as
    the stem of numbered names (`panda_joint`). Joints speak louder than links and groups, and
    these louder than the robot's own name. Of several robots that fit equally, the one whose name
    stands in the strings, or in `place` (the path of the controller, the name of its package).

    Raises RobotError when no robot or several fit, naming them.
    """
    given = tuple(strings)
    words = _words(given)
    robots = {name: load_robot(name) for name in robot_names()}
    evidence = {name: _evidence(robot, words) for name, robot in robots.items()}
    best = max(evidence.values(), default=(0, 0, 0))
    if not any(best):
        raise NoRobotNamedError(
            "the controller's strings name no joint, link or group of a known robot; "
            f"say which one it drives with --robot; {one_of(robots)}"
        )
    fitting = [name for name, found in evidence.items() if found[:2] == best[:2]]
    named = _named(fitting, robots, (*given, place))
    if len(named) == 1:
        return robots[named[0]]
    fitting = [name for name in named or fitting if evidence[name] == best] or named or fitting
    if len(fitting) > 1:
        raise RobotError(
            f"the controller's strings fit several robots: {', '.join(fitting)}; "
            "say which one it drives with --robot"
        )
    return robots[fitting[0]]


def _named(fitting: list[str], robots: dict[str, Robot], texts: Iterable[str]) -> list[str]:
    """Return those whose name stands in the texts as a word of its own.

    `ur5e` is no mention of `ur5`, and `ur5_moveit_config` is one.
    """
    whole = [
        word
        for text in texts
        for part in (PurePath(text).parts or (text,))
        for word in (part.lower(), *re.split(r"[^a-z0-9]+", part.lower()))
    ]
    words = set(whole)
    return [
        name for name in fitting if words & {name.lower(), *map(str.lower, robots[name].aliases)}
    ]


def _words(strings: Iterable[str]) -> frozenset[str]:
    words: set[str] = set()
    for string in strings:
        words.add(string)
        words.update(part for part in re.split(r"[/\s,;:.]+", string) if part)
    return frozenset(words)


def _evidence(robot: Robot, words: frozenset[str]) -> _Evidence:
    joints = {joint.name for joint in robot.joints} - _COMMON
    stems = {re.sub(r"\d+$", "", name) for name in joints}
    joints |= {stem for stem in stems if len(stem.rstrip("_")) > _SHORTEST_STEM}
    places = {*robot.link_names, *robot.groups, *(c.name for c in robot.controllers)} - _COMMON
    names = {robot.name, *robot.aliases}
    return len(joints & words), len(places & words), len(names & words)
