"""What speaks for a robot among the names of joints, links and groups in sources."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from tracerisk.pipeline.robot.evidence import JOINTS, JOINTS_OF_ANY, NAMES, PLACES, Evidence
from tracerisk.pipeline.robot.speech import Speech
from tracerisk.twin.robots.generic import is_finger_name
from tracerisk.twin.robots.index import RobotNames
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_names import Hint, is_number, is_plain, mentioned

_SHORTEST_STEM = 5  # `joint` alone says nothing about the arm
_HALF = 0.5  # the share of an arm's joints that must be named where their names are plain
_FEWEST = 3
_WHOLE = 0.1  # of the points of joints, those for a robot that has no other joints
_SHOWN = 4
_PARTS = "names parts of it"
# What so many robots call a part of theirs says nothing about which one it is.
_ANYBODYS = frozenset({"world", "base", "base_link", "link", "tool0", "open", "close", "home"})


@dataclass(frozen=True, slots=True)
class Parts:
    """The names of a robot's parts, whether it is shipped or of a workspace."""

    key: str
    """What evidence calls the robot."""
    joints: frozenset[str]
    """The joints that move."""
    arms: tuple[frozenset[str], ...]
    """The joints of each group."""
    places: frozenset[str]
    """Links, groups, controllers and named states."""
    own: bool
    """Whether it is described in the workspace: then plain names of groups are its own."""


def shipped_parts(robot: RobotNames) -> Parts:
    """Return the names of a shipped robot's parts."""
    return Parts(
        robot.name,
        frozenset(robot.joints),
        tuple(frozenset(group) for group in robot.groups.values()),
        frozenset({*robot.links, *robot.groups, *robot.controllers}),
        own=False,
    )


def described_parts(key: str, robot: Robot) -> Parts:
    """Return the names of the parts of a robot that the workspace describes.

    Groups of a robot that has none of its own are names that anybody gave it.
    """
    places = {robot.name, *robot.link_names}
    if not robot.assumes_names:
        places |= robot.groups.keys()
        places.update(state for states in robot.named_states.values() for state in states)
    return Parts(
        key,
        frozenset(joint.name for joint in robot.joints),
        tuple(frozenset(group.joints) for group in robot.groups.values()),
        frozenset(places) - _ANYBODYS,
        own=True,
    )


@dataclass(frozen=True, slots=True)
class _Named:
    """What one source names of one robot."""

    parts: Parts
    """The names of the robot's parts."""
    joints: frozenset[str]
    """The joints that are named, also those named by a common stem."""
    places: frozenset[str]
    """The links, frames and groups that are named."""
    is_telling: bool
    """Whether its joints can be meant as this robot's, and not as any arm's."""


def evidence_of_parts(robots: Sequence[Parts], speech: Speech) -> Iterator[Evidence]:
    """Yield what a source says for each of some robots by the names of their parts.

    A name counts as a whole, as a part of a ROS name (`/panda_arm_controller/command`), as the
    stem of numbered names (`panda_joint`), or behind another one (`panda_`, `joint1`). Names that
    any arm could have (`elbow_joint`) count where half of an arm's joints are named. A source
    that lists joints speaks against a robot that has none of them.
    """
    spoken = [_named(robot, speech) for robot in robots]
    listed = frozenset(name for name in speech.listed if not is_finger_name(name))
    most = max([len(listed), *(len(one.joints) for one in spoken if one.is_telling)], default=0)
    widest = max((len(_proper(one)) for one in spoken), default=0)
    for one in spoken:
        key = one.parts.key
        if one.joints and most:
            names = sorted(one.joints)
            explained = min(1.0, len(one.joints) / most)
            points = JOINTS * ((1 - _WHOLE) * explained + _WHOLE * _covered(one))
            if not one.is_telling:
                points = JOINTS_OF_ANY * explained
            yield _evidence(key, f"names {len(names)} of its joints", names, speech, points)
        elif one.joints:
            names = sorted(one.joints)
            points = JOINTS_OF_ANY * len(names) / max(len(names), _FEWEST)
            yield _evidence(key, f"names {len(names)} of its joints", names, speech, points)
        places = _proper(one)
        if places:
            points = PLACES * (0.5 + 0.5 * len(places) / widest)
            yield _evidence(key, _PARTS, sorted(places), speech, points)
        is_named = one.joints or (places and not one.parts.own)
        lacking, fewest = (_counted_on(one.parts, listed), 1) if is_named else (listed, _FEWEST)
        # Modules are written for more than one robot.
        if lacking and speech.share == 1.0:
            against = -JOINTS * min(1.0, len(lacking) / fewest)
            words = "lists joints that it lacks"
            yield _evidence(key, words, sorted(lacking), speech, against)


def _evidence(
    key: str, words: str, names: Sequence[str], speech: Speech, points: float
) -> Evidence:
    more = ", ..." if len(names) > _SHOWN else ""
    text = f"{speech.who} {words}: {', '.join(names[:_SHOWN])}{more}"
    kind: Literal["joints", "parts"] = "parts" if words == _PARTS else "joints"
    return Evidence(key, text, speech.file, speech.line_of(names), points * speech.share, kind)


def _named(parts: Parts, speech: Speech) -> _Named:
    words = speech.words | _built(parts, speech.words)
    joints = words & parts.joints
    stems = {re.sub(r"\d+$", "", joint) for joint in parts.joints}
    stems = {
        stem
        for stem in stems & words
        if len(stem.rstrip("_")) > _SHORTEST_STEM and not is_plain(stem)
    }
    places = words & parts.places
    # Names of whole namespaces (`/robot/limb/right`) stand within longer ones.
    places |= {
        name
        for name in parts.places
        if "/" in name and any(name[1:] in text for text in speech.strings)
    }
    tellable = {name for name in joints if not is_number(name)}
    listed = frozenset(speech.listed)
    is_telling = (
        bool(stems)
        or any(not is_plain(name) for name in joints)
        or _covers(parts, tellable)
        # The joints of a description of the workspace are its own, but for what anybody calls
        # a part: `gripper`.
        or (parts.own and any(not name.isalpha() for name in joints))
        or (parts.own and bool(listed) and listed <= joints)
    )
    return _Named(parts, joints | stems, places, is_telling)


def _counted_on(parts: Parts, listed: Collection[str]) -> frozenset[str]:
    """Return the listed joints that count on from those of a shipped arm: `joint5` of four."""
    shared = parts.joints & set(listed)
    if parts.own or not shared or not all(map(is_number, shared)):
        return frozenset()
    return frozenset(name for name in listed if is_number(name) and name not in parts.joints)


def _proper(one: _Named) -> frozenset[str]:
    """Return the places that are no robot's but this one's."""
    if one.parts.own:
        return one.places
    return frozenset(name for name in one.places if not is_plain(name))


def _covered(one: _Named) -> float:
    """Return the share of the joints of an arm that are named, of the arm with most."""
    shares = [len(one.joints & arm) / len(arm) for arm in one.parts.arms if arm]
    return max(shares, default=0.0)


def _covers(parts: Parts, joints: Collection[str]) -> bool:
    """Return whether half of the joints of an arm of the robot, and more than a few, are named."""
    return any(len(arm & set(joints)) >= max(_FEWEST, _HALF * len(arm)) for arm in parts.arms)


def _built(parts: Parts, words: frozenset[str]) -> frozenset[str]:
    """Return the joints and links that two words make: `panda_` before `joint1`."""
    prefixes = {word for word in words if re.fullmatch(r"[A-Za-z]\w*_", word)}
    return frozenset(
        name
        for name in (*parts.joints, *parts.places)
        for prefix in prefixes
        if name.startswith(prefix) and name.removeprefix(prefix) in words
    )


def evidence_of_names(
    hint: Hint, robots: Mapping[str, RobotNames], among: Collection[str]
) -> Iterator[Evidence]:
    """Yield what texts of one weight say for robots by their exact names.

    A text that names several of those in question shares its points among them.
    """
    votes: dict[str, list[tuple[str, float]]] = {}
    telling = 0
    for place, text in hint.texts.items():
        named = mentioned(text, robots) & frozenset(among)
        telling += bool(named)
        for name in sorted(named):
            votes.setdefault(name, []).append((place, 1.0 / len(named)))
    alone = {name for name, places in votes.items() if any(share == 1.0 for _, share in places)}
    for name, places in votes.items():
        if alone and name not in alone:
            continue  # a list of a maker's variants says nothing beside a text that names one
        place, _ = min(places, key=lambda pair: (-pair[1], len(pair[0]), pair[0]))
        points = NAMES[hint.what] * sum(share for _, share in places) / telling
        words = f"{name} is named in {hint.what}"
        yield Evidence(name, words, place, _line(hint, place, name), points, "name")


def _line(hint: Hint, place: str, name: str) -> int | None:
    """Return the line of a text with a name as it is written, where the text has its lines."""
    if not hint.has_lines:
        return None
    for number, line in enumerate(hint.texts[place].splitlines(), 1):
        if name in line.lower():
            return number
    return None
