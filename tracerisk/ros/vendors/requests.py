"""What a message asks of a described driver: numbers in SI units, goals of joints, poses, words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tracerisk.errors import one_of
from tracerisk.ros.transforms.poses import quaternion_from_columns, unit_quaternion
from tracerisk.ros.vendors.conventions import Conventions, Dimension
from tracerisk.ros.vendors.description import UNITS, Case, Condition, Value
from tracerisk.ros.vendors.message_paths import (
    SI,
    FieldError,
    is_message,
    is_of_ros,
    numbers_in,
    read,
)
from tracerisk.twin.physics.motion import PlanningError, Pose

_LARGEST: Mapping[str, float] = {"angle": math.tau + 0.1, "length": 10.0}

_RIGID = 1e-3
"""How far the axes of a rotation may be from unit length and from each other's normals."""

Goal = Sequence[float] | Mapping[str, float]
"""Positions or velocities: of all joints in their order, or of some by their names."""


@dataclass(eq=False)
class Request:
    """The values of one message; what cannot be read is a PlanningError of a bad request."""

    message: Any
    """The message as it was received."""
    _state: Mapping[str, Any]
    """The present values of the driver's state and parameters, by name."""
    _conventions: Conventions
    """The units and the form of rotations of the message."""
    _on_large: Callable[[Dimension], None] = lambda _: None
    """The function for a number too large for its unit: an angle above a turn in radians, a length
    above 10 m."""

    def meets(self, case: Case) -> bool:
        """Return whether the message holds what a case is for."""
        return all(self.of(one) in map(_text, one.values) for one in case.when)

    def of(self, condition: Condition) -> str:
        """Return what a condition looks at, as a text."""
        if condition.path.startswith("$"):
            return _text(self._state[condition.path[1:]])
        return _text(self._read(condition.path))

    def raw(self, value: Value) -> Any:
        """Return what a value holds, translated by its map."""
        constant: Any = value.constant
        if value.paths:
            each = [self._read(path) for path in value.paths]
            constant = each if value.is_list else each[0]
        if value.map is not None:
            text = _text(constant)
            if text not in value.map and "else" not in value.map:
                raise PlanningError(
                    "bad_request", f"{value.key} is {text}; {one_of(value.map, text)}"
                )
            return value.map[text] if text in value.map else value.map["else"]
        if value.default is not None and not value.paths:
            return value.default if constant is None else constant
        return constant

    def number(self, value: Value | None, dimension: Dimension, unit: str = "") -> float | None:
        """Return a number in SI units, or its share; None where none is given.

        `unit` is that of a number without one. What is 0 or less gives way to the default, and
        where there is none, to None.
        """
        if value is None:
            return None
        numbers = numbers_in(self.raw(value))
        factor = UNITS[value.unit or unit] if value.unit or unit else 1.0
        if not value.unit and not unit and dimension != "plain":
            factor = self._conventions.factor(dimension)
        if not numbers:
            raise PlanningError("bad_request", f"{value.key} holds no number")
        # A list of limits, one for each joint, bounds them all by the least.
        number = min(numbers, key=abs) if len(numbers) > 1 else numbers[0]
        if not math.isfinite(number):
            raise PlanningError("bad_request", f"{value.key} is not finite")
        if number <= 0:
            default = value.default
            return float(default) * factor if isinstance(default, int | float) else None
        return number * factor

    def signed(self, value: Value, dimension: Dimension = "plain") -> float:
        """Return a number of either sign in SI units."""
        numbers = numbers_in(self.raw(value))
        if not numbers or not math.isfinite(numbers[0]):
            raise PlanningError("bad_request", f"{value.key} holds no finite number")
        factor = UNITS[value.unit] if value.unit else self._conventions.factor(dimension)
        return numbers[0] * factor

    def seconds(self, value: Value | None) -> float | None:
        """Return a duration [s]: a number, or a message of one."""
        if value is None:
            return None
        raw = self.raw(value)
        for whole, part in (("sec", "nanosec"), ("secs", "nsecs")):
            if hasattr(raw, whole) and hasattr(raw, part):
                length = getattr(raw, whole) + getattr(raw, part) * 1e-9
                return length if length > 0 else None
        return self.number(value, "time")

    def flag(self, value: Value | None, *, default: bool) -> bool:
        """Return whether something is asked for."""
        return default if value is None else bool(self.raw(value))

    def word(self, value: Value | None) -> str | None:
        """Return a word, None where none is given."""
        if value is None:
            return None
        raw = self.raw(value)
        return str(raw) if raw not in ("", None) else value.default

    # Goals of joints

    def goals(self, value: Value, names: Value | None, dimension: Dimension) -> list[Goal]:
        """Return the goals of joints that a value holds: one, or those of a way."""
        raw = self.raw(value)
        listed = None if names is None else [str(item) for item in self.raw(names)]
        several = raw if self._is_several(value, raw) else [raw]
        factor = UNITS[value.unit] if value.unit else self._conventions.factor(dimension)
        return [self._goal(value, item, listed, factor) for item in several]

    def _is_several(self, value: Value, raw: Any) -> bool:
        if value.is_list or is_message(raw) or not hasattr(raw, "__len__") or not len(raw):
            return False
        return is_message(raw[0]) or hasattr(raw[0], "__len__")

    def _goal(self, value: Value, raw: Any, names: Sequence[str] | None, factor: float) -> Goal:
        is_si = is_of_ros(raw)
        if is_si:
            # JointState and its like have names and numbers beside one another, in SI units.
            factor, named = 1.0, getattr(raw, "name", None) or getattr(raw, "joint_names", None)
            names = [str(item) for item in named] if named else names
            raw = getattr(raw, "position", getattr(raw, "positions", raw))
        numbers = numbers_in(raw)
        if numbers is None:
            raise PlanningError("bad_request", f"{value.key} holds no numbers of joints")
        if not all(math.isfinite(item) for item in numbers):
            raise PlanningError("bad_request", f"{value.key} holds a number that is not finite")
        if not is_si and not value.unit:
            self._look_at("angle", numbers)
        scaled = [item * factor for item in numbers]
        if not names:
            return scaled
        if len(names) != len(scaled):
            raise PlanningError(
                "bad_request", f"{len(scaled)} numbers for {len(names)} names of joints"
            )
        return dict(zip(names, scaled, strict=True))

    # Poses

    def poses(self, value: Value) -> list[tuple[Pose, str]]:
        """Return the poses that a value holds, each with the frame in its header, or empty."""
        raw = self.raw(value)
        is_many = not value.is_list and hasattr(raw, "__len__") and len(raw) and not is_message(raw)
        if is_many and (is_message(raw[0]) or hasattr(raw[0], "__len__")):
            return [self._pose(value, item) for item in raw]
        return [self._pose(value, raw)]

    def _pose(self, value: Value, raw: Any) -> tuple[Pose, str]:
        if is_message(raw) and hasattr(raw, "pose"):
            header = getattr(raw, "header", None)
            return self._pose(value, raw.pose)[0], str(getattr(header, "frame_id", ""))
        if is_message(raw):
            place = getattr(raw, "position", getattr(raw, "translation", None))
            turn = getattr(raw, "orientation", getattr(raw, "rotation", None))
            if place is not None and turn is not None:
                return Pose(self._place(value, place), self._turn(value, turn)), ""
        numbers = numbers_in(raw)
        if numbers is None:
            raise PlanningError("bad_request", f"{value.key} holds no pose")
        if is_of_ros(raw):
            return SI.pose(numbers), ""
        self._look_at("length", numbers[:3])
        if len(numbers) == 6:
            self._look_at("angle", numbers[3:])
        return self._conventions.pose(numbers), ""

    def transform(self, value: Value) -> Pose:
        """Return the pose of a matrix of 16 numbers, column by column."""
        numbers = numbers_in(self.raw(value))
        if numbers is None or len(numbers) != 16 or not all(map(math.isfinite, numbers)):
            raise PlanningError("bad_request", f"{value.key} holds no matrix of 16 numbers")
        length = self._conventions.factor("length")
        x, y, z = (number * length for number in numbers[12:15])
        columns = numbers[:3], numbers[4:7], numbers[8:11]
        if not _is_turn(*columns) or numbers[3::4] != [0.0, 0.0, 0.0, 1.0]:
            raise PlanningError("bad_request", f"{value.key} is no transformation of a rigid body")
        return Pose((x, y, z), quaternion_from_columns(*columns))

    def position(self, value: Value) -> tuple[float, float, float]:
        """Return a position [m]."""
        return self._place(value, self.raw(value))

    def orientation(self, value: Value) -> tuple[float, float, float, float]:
        """Return an orientation."""
        return self._turn(value, self.raw(value))

    def _place(self, value: Value, raw: Any) -> tuple[float, float, float]:
        numbers = numbers_in(raw)
        if numbers is None or len(numbers) != 3 or not all(map(math.isfinite, numbers)):
            raise PlanningError("bad_request", f"{value.key} holds no position of three numbers")
        factor = 1.0 if is_of_ros(raw) else self._conventions.factor("length")
        if not is_of_ros(raw):
            self._look_at("length", numbers)
        x, y, z = (number * factor for number in numbers)
        return x, y, z

    def _turn(self, value: Value, raw: Any) -> tuple[float, float, float, float]:
        numbers = numbers_in(raw)
        if numbers is None or len(numbers) not in (3, 4) or not all(map(math.isfinite, numbers)):
            raise PlanningError("bad_request", f"{value.key} holds no turn of 3 or 4 numbers")
        if len(numbers) == 4:
            return unit_quaternion(numbers)
        return self._conventions.turn(numbers)

    def twist(self, value: Value) -> tuple[list[float], list[float]]:
        """Return a velocity of the tool: linear [m/s], angular [rad/s]."""
        raw = self.raw(value)
        raw = getattr(raw, "twist", raw)
        if is_message(raw) and hasattr(raw, "linear") and hasattr(raw, "angular"):
            parts = [numbers_in(raw.linear) or [], numbers_in(raw.angular) or []]
            if is_of_ros(raw) or is_of_ros(raw.linear):
                return parts[0], parts[1]
            numbers: list[float] | None = [*parts[0], *parts[1]]
        else:
            numbers = numbers_in(raw)
        if numbers is None or len(numbers) != 6 or not all(map(math.isfinite, numbers)):
            raise PlanningError("bad_request", f"{value.key} holds no twist of six numbers")
        length = self._conventions.factor("length")
        angle = self._conventions.factor("angle")
        return [number * length for number in numbers[:3]], [
            number * angle for number in numbers[3:]
        ]

    def _look_at(self, dimension: Dimension, numbers: Sequence[float]) -> None:
        is_si = self._conventions.factor(dimension) == 1.0
        if is_si and max(map(abs, numbers), default=0.0) > _LARGEST[dimension]:
            self._on_large(dimension)

    def _read(self, path: str) -> Any:
        if path.startswith("$"):
            return self._state[path[1:]]
        try:
            return read(self.message, path)
        except FieldError as error:
            raise PlanningError("bad_request", str(error)) from error


def _is_turn(*columns: Sequence[float]) -> bool:
    """Return whether columns are those of a rotation."""
    (a, b, c), (d, e, f), _ = columns
    third = (b * f - c * e, c * d - a * f, a * e - b * d)
    lengths = [math.hypot(*column) for column in columns]
    return (
        max(abs(length - 1.0) for length in lengths) < _RIGID
        and math.dist(third, columns[2]) < _RIGID
    )


def _text(value: Any) -> str:
    """Return a value as maps and conditions write it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)
