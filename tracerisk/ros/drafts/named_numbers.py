"""Numbers for what has only a name: a coordinate that the tool reaches, a joint, in said units.

Names, help texts, comments and what the code makes of a number say whether it is in degrees or
millimetres; without either it is in radians and metres.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees

_DEGREES = re.compile(
    r"(?<![a-z])deg(ree)?s?(?![a-z]|\s*\()|°|\bradians\s*\(|deg2rad|pi\s*/\s*180|180(\.0*)?\s*\*\s*[\w.]*pi\b"
)
_RADIANS = re.compile(r"\bdegrees\s*\(|rad2deg|\*\s*180(\.0*)?\s*/\s*[\w.]*pi\b")
_MILLIMETRES = re.compile(
    r"(?<![a-z])mm(?![a-z])|millimet|/\s*1000(\.0*)?\b|/\s*1e3\b|\*\s*(0?\.001\b|1(\.0)?e-0?3\b)"
)
_METRES = re.compile(r"\*\s*1000(\.0*)?\b|\*\s*1e3\b")
_CENTIMETRES = re.compile(r"(?<![a-z])cm(?![a-z])|centimet|/\s*100(\.0*)?\b|\*\s*0?\.01\b")

_UNIT = re.compile(r"_?(deg(ree)?s?|rad(ian)?s?|mm|cm|m)$")
_WORDS = re.compile(r"[_\s.]+")
_STEP = re.compile(r"(^|_)(d|delta|diff|offset|rel(ative)?|step|inc(rement)?|shift)(_|$)|^d[xyz]$")
_COORDINATE = re.compile(r"^(?:\w+_)?([xyz])(?:_(?:pos(ition)?|coord\w*|goal|target|val(ue)?))?$")
_TURN = re.compile(r"^(?:\w+_)?(?:r([xyz])|(roll|pitch|yaw))(?:_\w+)?$")
_JOINT = re.compile(r"^(?:j|q|theta|angle|axis|(?:\w+_)?joint)_?(\d)$")
_ANGLE = re.compile(r"(^|_)(angles?|rot(ation)?|theta|turn|tilt|joints?)(_|$)")
_LENGTH = re.compile(
    r"(^|_)(height|depth|width|distance|dist|radius|length|clearance|approach|retreat|lift)(_|$)"
)
_WAITS = re.compile(r"(^|_)time_?out(_|$)")
_LASTS = re.compile(
    r"(^|_)(duration|(move|moving|motion|travel|execution|trajectory)_time|time_from_start)(_|$)"
)
_PER_SECOND = {"ms": 1e3, "msec": 1e3, "millis": 1e3, "milliseconds": 1e3}
_WAITS_S = 60.0  # as long as a caller has patience
_LASTS_S = 3.0  # as long as a motion takes
_STEP_M = 0.05
_STEP_RAD = 0.2


@dataclass(frozen=True, slots=True)
class Units:
    """In which units numbers are: how many of them are a radian, how many a metre."""

    per_radian: float = 1.0
    """Angles: 1, or 180/pi for degrees."""
    per_metre: float = 1.0
    """Lengths: 1, 100 or 1000."""

    def angle(self, radians: float) -> float:
        """Return an angle [rad] in the unit of angles."""
        value = radians * self.per_radian
        return round(value, 1) if self.per_radian > 1.0 else value

    def length(self, metres: float) -> float:
        """Return a length [m] in the unit of lengths."""
        return round(metres * self.per_metre, 4)


SI = Units()
"""Radians and metres."""


def units_of(name: str, *texts: str) -> Units:
    """Return the units that a name and the first text give which give any but SI units."""
    return next((units for text in texts if (units := units_said(f"{name} {text}")) != SI), SI)


def units_said(text: str) -> Units:
    """Return the units that a text names, or to which code converts: `radians(x)`, `y / 1000`."""
    said = text.lower()
    per_radian = degrees(1.0) if _DEGREES.search(said) and not _RADIANS.search(said) else 1.0
    if _METRES.search(said):
        return Units(per_radian)
    millimetres, centimetres = _MILLIMETRES.search(said), _CENTIMETRES.search(said)
    return Units(per_radian, 1000.0 if millimetres else 100.0 if centimetres else 1.0)


@dataclass(frozen=True, slots=True)
class Reach:
    """A place of the tool and a posture of the arm, in the units of the robot."""

    position: tuple[float, ...]
    """Where the tool is in the frame of the base link, (3,) [m]."""
    turn: tuple[float, ...]
    """Roll, pitch and yaw of the tool, (3,) [rad]."""
    posture: tuple[float, ...]
    """A position of each joint of the arm [rad or m]."""


def named_number(name: str, units: Units, reach: Reach) -> float | None:
    """Return a number for what is called `name`; None if unknown.

    A place is reachable, and time is long enough for a motion.
    """
    plain = _WORDS.sub("_", name.strip("-_ ").replace("-", "_").lower())
    plain = _UNIT.sub("", plain) or plain
    if lasting := lasting_number(plain):
        return lasting
    is_step = _STEP.search(plain) is not None
    turn, joint, place = _TURN.match(plain), _JOINT.match(plain), _COORDINATE.match(plain)
    if turn is not None:
        at = "xyz".index(turn[1]) if turn[1] else ("roll", "pitch", "yaw").index(turn[2])
        return units.angle(_STEP_RAD if is_step else reach.turn[at])
    if joint is not None:
        at = int(joint[1]) - 1
        return units.angle(reach.posture[at]) if 0 <= at < len(reach.posture) else None
    if place is not None:
        at = "xyz".index(place[1])
        return units.length(_STEP_M if is_step else reach.position[at])
    if (_ANGLE.search(plain) or is_step) and units.per_radian > 1.0:
        return units.angle(_STEP_RAD)
    if (_LENGTH.search(plain) or is_step) and units.per_metre > 1.0:
        return units.length(_STEP_M)
    return None


def lasting_number(name: str) -> float:
    """Return the number for a time that is waited or that a motion takes; 0 for other names."""
    plain = name.lower()
    seconds = _WAITS_S if _WAITS.search(plain) else _LASTS_S if _LASTS.search(plain) else 0.0
    return seconds * _PER_SECOND.get(plain.rpartition("_")[2], 1.0)


def lasting_numbers(name: str, numbers: Sequence[float]) -> Sequence[float]:
    """Return the numbers with which the code compares `name`; of a time one that is long enough.

    `timeout > 0` asks for no more than that there is one.
    """
    lasting = lasting_number(name)
    is_long = bool(numbers) and numbers[0] > 1.0
    return (lasting,) if lasting and not is_long else numbers


def numbers_in_place(count: int, units: Units, reach: Reach) -> Sequence[float] | None:
    """Return so many numbers: of all joints, of a position, or of it with a turn; None else."""
    if count == len(reach.posture):
        return [units.angle(joint) for joint in reach.posture]
    position = [units.length(metres) for metres in reach.position]
    turn = [units.angle(radians) for radians in reach.turn]
    return {3: position, 6: [*position, *turn]}.get(count)
