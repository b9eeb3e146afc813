"""Which robots a text names, as words of their own, and which evidence decides between several.

A name that any robot's part may have identifies none: `is_plain`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from tracerisk.twin.robots.index import RobotNames

EVERYDAY = frozenset({"fetch"})
"""Robots whose bare name is a word of everyday English: only their longer names are mentions."""

_APART = "\x00"

_PLAIN = frozenset({
    "action", "actuator", "angle", "arm", "arms", "axis", "bar", "base", "body", "both",
    "bracket", "camera", "cmd", "column", "command", "controller", "controllers", "drive",
    "dummy", "ee", "eef", "effector", "effort", "elbow", "end", "finger", "fingers", "fixed",
    "flange", "flex", "follow", "footprint", "forearm", "frame", "front", "ft", "grasping",
    "gripper", "grippers", "group", "half", "hand", "head", "inertia", "inner", "input", "j",
    "jaw", "jaws", "joint", "joints", "knuckle", "l", "left", "leftfinger", "lift", "limb",
    "link", "lower", "manipulator", "map", "mount", "mounting", "moving", "odom", "outer",
    "output", "pad", "palm", "pan", "part", "pitch", "plate", "pos", "position", "prop", "r",
    "revolute", "right", "rightfinger", "robot", "robotiq", "roll", "root", "rotate", "sensor",
    "shoulder", "state", "states", "tcp", "thumb", "tilt", "tip", "to", "tool", "torso", "traj",
    "trajectory", "twist", "upper", "upperarm", "vel", "velocity", "visual", "waist", "wheel",
    "with", "world", "wrist", "yaw",
})  # fmt: skip
_NUMBERED = frozenset({"axis", "j", "joint", "link"})


@dataclass(frozen=True, slots=True)
class Hint:
    """Texts of one weight that may name the robot, by the file or folder they are from.

    `what` says in a message what they are: `its comments`. `is_telling` says that a name in them
    is the controller's own robot even where nothing else speaks for it.
    """

    what: str
    texts: Mapping[str, str]
    is_telling: bool = False


@dataclass(slots=True)
class Verdict:
    """What the hints came to: the robots still in question, and how one was singled out.

    `said` are the mentions that left several in question, heaviest first.
    """

    left: tuple[str, ...]
    reason: str = ""
    said: list[str] = field(default_factory=list)


def mentioned(text: str, robots: Mapping[str, RobotNames]) -> frozenset[str]:
    """Return the names of the robots that a text names, by their name or an alias.

    A name is a word of its own: `ur5e` is no mention of `ur5`; `ur5_moveit_config`, `UR5Node`,
    `UR-5` and `ur 5` are. What is part of a longer name of another robot is none.
    """
    text = _plain(text)
    found: set[str] = set()
    for phrase, names in _phrases(robots):
        wanted = f" {phrase} "
        # What was read is not read again as a shorter name; neighbours share a blank.
        while wanted in text:
            found |= names
            text = text.replace(wanted, f" {_APART} ")
    return frozenset(found)


def words_in(strings: Iterable[str]) -> frozenset[str]:
    """Return the strings, and their parts between slashes, blanks and stops."""
    words: set[str] = set()
    for string in strings:
        words.add(string)
        words.update(part for part in re.split(r"[/\s,;:.]+", string) if part)
    return frozenset(words)


def decide(
    candidates: Iterable[str], robots: Mapping[str, RobotNames], hints: Iterable[Hint]
) -> Verdict:
    """Return which of several robots the hints single out, the heaviest hint first.

    Of texts of one weight those count that name one candidate alone, and these must agree: a list
    of a maker's variants says nothing. A mention of several narrows the question to these.
    """
    verdict = Verdict(tuple(candidates))
    for hint in hints:
        of = {name: robots[name] for name in verdict.left}
        # Longer names of robots out of question are no mention of those in question.
        named = {place: mentioned(text, robots) & of.keys() for place, text in hint.texts.items()}
        votes = {place: names for place, names in named.items() if len(names) == 1}
        chosen = frozenset[str]().union(*votes.values())
        if len(chosen) == 1:
            (name,) = chosen
            place = min(votes, key=lambda each: (len(each), each))
            verdict.left, verdict.reason = (name,), f"{name} is named in {hint.what} ({place})"
            return verdict
        several = chosen or frozenset[str]().union(*named.values())
        if several:
            verdict.left = tuple(name for name in verdict.left if name in several)
            verdict.said.append(f"{hint.what}: {', '.join(verdict.left)}")
    return verdict


def _phrases(robots: Mapping[str, RobotNames]) -> list[tuple[str, set[str]]]:
    """Return what robots are called in plain words, with those called so, longer ones first."""
    found: dict[str, set[str]] = {}
    for name, robot in robots.items():
        for called in {robot.name, *robot.aliases} - EVERYDAY:
            phrase = " ".join(_split(called.lower()))
            apart = re.sub(r"(?<=[a-z])(?=\d)", " ", phrase)
            for each in (phrase, apart):
                found.setdefault(each, set()).add(name)
    return sorted(found.items(), key=lambda each: (-len(each[0]), each[0]))


def _plain(text: str) -> str:
    """Return a text as words between blanks, twice: as it is, and with its CamelCase parted."""
    parted = re.sub(r"(?<=[a-z0-9])(?=[A-Z][a-z])", " ", text)
    words = [*_split(text.lower()), _APART, *_split(parted.lower())]
    return f" {' '.join(words)} "


def _split(text: str) -> list[str]:
    return re.findall(r"[a-z0-9]+", text)


def is_plain(name: str) -> bool:
    """Return whether a name is made of words that any robot's parts may have: `elbow_joint`.

    A name of several levels (`/robot/limb/right`) is none.
    """
    return "/" not in name and _letters(name) <= _PLAIN


def is_number(name: str) -> bool:
    """Return whether a name only counts: `joint1`, `joint_2`."""
    return _letters(name) <= _NUMBERED


def _letters(name: str) -> set[str]:
    return {word for word in re.split(r"[^a-z]+", name.lower()) if word}
