"""Find the robot that a controller speaks of, from the strings in its source."""

from __future__ import annotations

import re
from collections.abc import Iterable

from tracerisk.errors import RobotError, one_of
from tracerisk.twin.robot import Robot, load_robot, robot_names

# What many robots call a part of theirs says nothing about which one it is.
_COMMON = {"arm", "arm_controller", "base_link", "gripper", "hand", "manipulator", "tool0"}
_SHORTEST_STEM = 5  # `joint` alone says nothing about the arm


def detect_robot(strings: Iterable[str]) -> Robot:
    """Return the one shipped robot that the strings name joints, links or groups of.

    A string counts as a whole, as a part of a ROS name (`/panda_arm_controller/command`), or as
    the stem of numbered names (`panda_joint`). Joints speak louder than links and groups, and
    these louder than the robot's own name.

    Raises RobotError when no robot or several fit, naming them.
    """
    words = _words(strings)
    evidence = {name: _evidence(load_robot(name), words) for name in robot_names()}
    best = max(evidence.values(), default=(0, 0, 0))
    if not any(best):
        raise RobotError(
            "the controller's strings name no joint, link or group of a known robot; "
            f"say which one it drives with --robot; {one_of(robot_names())}"
        )
    fitting = [name for name, found in evidence.items() if found == best]
    if len(fitting) > 1:
        raise RobotError(
            f"the controller's strings fit several robots: {', '.join(fitting)}; "
            "say which one it drives with --robot"
        )
    return load_robot(fitting[0])


def _words(strings: Iterable[str]) -> frozenset[str]:
    words: set[str] = set()
    for string in strings:
        words.add(string)
        words.update(part for part in re.split(r"[/\s,;:.]+", string) if part)
    return frozenset(words)


def _evidence(robot: Robot, words: frozenset[str]) -> tuple[int, int, int]:
    joints = {joint.name for joint in robot.joints}
    stems = {re.sub(r"\d+$", "", name) for name in joints}
    joints |= {stem for stem in stems if len(stem.rstrip("_")) > _SHORTEST_STEM}
    places = {*robot.link_names, *robot.groups, *(c.name for c in robot.controllers)} - _COMMON
    names = {robot.name, *robot.aliases}
    return len(joints & words), len(places & words), len(names & words)
