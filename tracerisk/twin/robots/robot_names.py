"""Which robots a text names, as words of their own.

A name that any robot's part may have identifies none: `is_plain`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache

from tracerisk.twin.robots.index import RobotNames

EVERYDAY = frozenset({"fetch"})
"""Robots whose bare name is a word of everyday English: only their longer names are mentions."""

_APART = "\x00"
# Behind a robot's name these make another model's: `gen3_lite` is no `gen3`.
_MODELS = frozenset({"lite", "mini", "nano", "micro", "pro", "xl", "ii", "iii", "mk2", "junior"})

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
_LETTER_ALONE = re.compile(r"(?<![A-Za-z0-9])(?<![A-Za-z0-9][-_/ ])(?=[A-Za-z](?![A-Za-z0-9]))")
_NUMBERED = frozenset({"axis", "j", "joint", "link"})


OTHERS_OF_MAKER: Mapping[str, tuple[str, ...]] = {
    "mycobot": (
        *("mech[ _-]?arm", "mypalletizer", r"myarm[ _-]?[mc]?[ _-]?\d{3}", "mybuddy"),
        "ultra[ _-]?arm",
    ),
    # The one with two arms, whose parts are called `arm_right_7_link`.
    "tiago": (
        r"tiago[ _-]?dual",
        r"tiago ?\+\+",
        r"arm_(?:left|right)_(?:torso|\d_(?:link|joint))",
    ),
}
"""Patterns of words that only arms that are not shipped have, by how the names of those shipped
arms begin whose messages or name they share. Any program may call its arm `myarm`: that alone is
none."""


@dataclass(frozen=True, slots=True)
class Hint:
    """Texts of one weight that may name the robot."""

    what: str
    """What they are, for messages: `its comments or docstrings`."""
    texts: Mapping[str, str]
    """Each text by the file or folder that it is from."""
    has_lines: bool = False
    """Whether they are whole files, with their lines."""


def mentioned(text: str, robots: Mapping[str, RobotNames]) -> frozenset[str]:
    """Return the names of the robots that a text names, by their name or an alias.

    A name is a word of its own: `ur5e` is no mention of `ur5`; `ur5_moveit_config`, `UR5Node`,
    `UR-5` and `ur 5` are. What is part of a longer name of another robot is none; nor
    is `gen3_pro` one of `gen3`, or `crx10ia/l` of `crx10ia`.
    """
    text = _plain(text)
    texts: set[str] = set()
    shared: dict[str, frozenset[str]] = {}
    called = tuple((name, (robot.name, *robot.aliases)) for name, robot in robots.items())
    for phrase, names in _phrases(called):
        wanted = f" {phrase} "
        # What was read is not read again as a shorter name; neighbours share a blank.
        while (at := text.find(wanted)) >= 0:
            rest = text[at + len(wanted) :]
            others = {word for name in names for word in robots[name].other_models}
            if rest.partition(" ")[0] not in _MODELS | others:
                if len(names) > 1:
                    shared[phrase] = names
                else:
                    texts |= names
            text = f"{text[:at]} {_APART} {rest}"
    named = {word for name in texts for word in _split(name)}
    # Of several robots that are called so, the one that is also named in full is meant.
    more = (names for phrase, names in shared.items() if not named.issuperset(phrase.split()))
    return frozenset(texts.union(*more))


def another_arm(text: str, robot: str) -> str | None:
    """Return the arm of a robot's maker that a text names, and that is not shipped."""
    said = text.lower()
    others = (OTHERS_OF_MAKER[name] for name in OTHERS_OF_MAKER if robot.startswith(name))
    words = (re.search(f"(?<![a-z]){other}(?![a-z])", said) for names in others for other in names)
    return next((word[0] for word in words if word is not None), None)


def another_number(text: str, robot: str) -> str | None:
    """Return the model of another number that a text names: `SO-ARM101` beside `so100`."""
    own = re.fullmatch(r"([a-z]{2,})_?(\d+)[a-z]*", robot)
    if own is None:
        return None
    stem, number = own.groups()
    model = rf"(?<![a-z0-9]){stem}[ _-]?(?:arm)?[ _-]?(\d{{{len(number)}}})(?![0-9])"
    found = tuple(re.finditer(model, text.lower()))
    if any(one[1] == number for one in found):
        return None
    return next((one[0] for one in found), None)


def words_in(strings: Iterable[str]) -> frozenset[str]:
    """Return the strings, and their parts between slashes, blanks and stops."""
    words: set[str] = set()
    for string in strings:
        words.add(string)
        words.update(part for part in re.split(r"[/\s,;:.]+", string) if part)
    return frozenset(words)


@lru_cache(maxsize=2)
def _phrases(
    robots: tuple[tuple[str, tuple[str, ...]], ...],
) -> tuple[tuple[str, frozenset[str]], ...]:
    """Return what robots are called in plain words, with those called so, longer ones first.

    Each robot is given with its name and aliases. A run asks about the same ones for each text.
    """
    phrases: dict[str, set[str]] = {}
    for name, called in robots:
        for words in {*called} - EVERYDAY:
            phrase = " ".join(_split(words.lower()))
            apart = re.sub(r"(?<=[a-z])(?=\d)", " ", phrase)
            for text in (phrase, apart):
                phrases.setdefault(text, set()).add(name)
    ordered = sorted(phrases.items(), key=lambda item: (-len(item[0]), item[0]))
    return tuple((phrase, frozenset(names)) for phrase, names in ordered)


def _plain(text: str) -> str:
    """Return a text as words between blanks, twice: as it is, and with its CamelCase parted.

    A letter alone belongs to the word before it in `open_manipulator_p`, and not in `arm, p`.
    """
    text = _LETTER_ALONE.sub(_APART, text)
    parted = re.sub(r"(?<=[a-z0-9])(?=[A-Z][a-z])", " ", text)
    words = [*_split(text.lower()), _APART, *_split(parted.lower())]
    return f" {' '.join(words)} "


def _split(text: str) -> list[str]:
    return re.findall(rf"[a-z0-9]+|{_APART}", text)


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
