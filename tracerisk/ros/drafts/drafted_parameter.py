"""A value for a parameter that nobody gives: by its type, its name and how the code uses it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence, Set
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Need, last_part
from tracerisk.ros.drafts.asked_results import (
    Shape,
    compared_results,
    results_of_name,
    shape_of,
    used_as,
    written_name,
)
from tracerisk.ros.drafts.named_numbers import named_number, units_of
from tracerisk.ros.drafts.posture_numbers import numbers_of
from tracerisk.ros.drafts.said_around import said_of_name
from tracerisk.ros.drafts.usable_values import UsableValues, is_on

_TYPED: Mapping[str, Any] = {
    "integer": 1,
    "double": 0.1,
    "string": "",
    "byte_array": [0],
    "bool_array": [False],
    "integer_array": [0],
    "double_array": [0.0],
    "string_array": [""],
}
_OF_SHAPE = "of the shape that the code takes"
ANY_NUMBER: Set[float] = frozenset({0.5, 1})
"""What stands for a number of which the code says only that it is one."""
_OF_NUMBERS = ("", "int", "float", "integer", "double")
_READS = ("get_param", "get_param_cached", "get_parameter", "declare_parameter", "get_parameter_or")
_ANONYMOUS = re.compile(r"^/(?:[\w/]*/)?\w+_\d+_\d{9,}/")
_SIMULATED = re.compile(r"^use_sim_time$|verbose|debug|preview", re.IGNORECASE)
_NUMBERS: tuple[tuple[str, Any], ...] = (
    (r"(^|_)(rate|hz|freq(uency)?)$", 10.0),
    (r"(^|_)(num|number|count|n|times|cycles|parts)(_|$)", 1),
    (r"(vel(ocity)?|speed|acc(el(eration)?)?|scal(e|ing)(_factor)?)$", 0.1),
    (r"(^|_)(timeout|duration|period|delay|time|wait)$", 1.0),
)


def parameter_key(need: Need, place: Location | None) -> str:
    """Return the name under which a scenario gives a parameter."""
    key = need.name
    written = next((name for call in _READS if (name := written_name(place, call))), "")
    if written.startswith("~") or _ANONYMOUS.match(key):
        # Private to the node, whose own name may be another each time.
        key = f"~{_ANONYMOUS.sub('', key)}" if not written.startswith("~") else written
    return key


def other_values(need: Need, place: Location | None, default: Any) -> tuple[str | bool, ...]:
    """Return the values beside its default for which the code asks of a parameter, at most two.

    A switch is put on, and off where its name says that nothing is to move: `dry_run`.
    """
    last = last_part(need.name)
    if isinstance(default, bool):
        return (not default,) if default is not is_on(last) and not _SIMULATED.search(last) else ()
    if not isinstance(default, str) or not default or "/" in default:
        return ()
    known = [text for text in results_of_name(place, last, _READS) if isinstance(text, str)]
    if default.lower() not in {text.lower() for text in known} and len(known) != 1:
        # What it is compared with is of another kind, as the end of a file's name.
        return ()
    others = (text for text in dict.fromkeys(known) if text.lower() != default.lower())
    return tuple(text for text in others if is_on(text))[:2]


def drafted_parameter(need: Need, place: Location | None, values: UsableValues) -> tuple[Any, str]:
    """Return a value for a parameter, and where it is from."""
    last = last_part(need.name)
    literals = next((result for call in _READS if (result := compared_results(place, call))), ())
    kind = need.type_name or next((use for call in _READS if (use := used_as(place, call))), "")
    fitting = [literal for literal in literals if _fits(literal, kind)]
    units = units_of(last, said_of_name(place, last))
    reached = named_number(last, units, values.reach) if kind in _OF_NUMBERS else None
    is_whole = kind in ("int", "integer")
    if reached is not None and set(literals) <= ANY_NUMBER:
        return round(reached) if is_whole else reached, f"within reach of {values.robot.name}"
    if fitting:
        return fitting[0], "as the code compares it"
    shape, keys = _shape(place) if kind not in _TYPED else ("", ())
    if shape in ("joints", "list of joints"):
        posture = list(values.posture)
        return (posture if shape == "joints" else [posture]), _OF_SHAPE
    if shape == "mapping":
        return _mapping(keys, values), _OF_SHAPE
    names = [joint.name for joint in values.joints]
    if kind in ("", "string_array") and re.search(r"(^|_)joint(s|_names)$", last):
        return names, f"the joints of {values.robot.name}"
    if kind == "double_array":
        numbers = numbers_of(last, None, values.posture, values.pose, units)
        if numbers and "pose" in last:
            return numbers, f"a pose that {values.robot.name} reaches"
        if re.search(r"joint|pos|home|ready|state|angle", last):
            posture = [units.angle(value) for value in values.posture]
            return posture, f"near where {values.robot.name} begins"
    if kind in ("", "string", "str"):
        text = values.text(last, ())
        if text:
            return text, f"of {values.robot.name}"
    for pattern, number in _NUMBERS if kind in _OF_NUMBERS else ():
        if re.search(pattern, last):
            return int(number) or 1 if is_whole else number, "a usual value"
    if kind == "bool":
        return is_on(last), "a value of its type"
    plain = {"int": 1, "float": 0.1, "str": last}.get(kind)
    if plain is not None:
        return plain, "as the code uses it"
    if shape == "list":
        return [0.1], _OF_SHAPE
    return _TYPED.get(kind, 1), "a value of its type" if kind in _TYPED else "a guess"


def _shape(place: Location | None) -> tuple[Shape, tuple[str, ...]]:
    shapes = (shape_of(place, call) for call in _READS)
    return next((found for found in shapes if found[0]), ("", ()))


def _mapping(keys: Sequence[str], values: UsableValues) -> dict[str, float]:
    """Return a mapping with these keys: coordinates are those of a pose that the robot reaches."""
    at = dict(zip("xyz", values.pose.position, strict=True))
    turn = dict(zip(("qx", "qy", "qz", "qw"), values.pose.orientation, strict=True))
    known = {**at, **turn, **dict.fromkeys(("roll", "pitch", "yaw"), 0.0)}
    return {key: known.get(key, 0.1) for key in keys}


def _fits(value: Any, kind: str) -> bool:
    wanted: Mapping[str, type | tuple[type, ...]] = {
        "string": str, "str": str, "bool": bool, "integer": int, "int": int,
        "double": (int, float), "float": (int, float), "": (str, int, float),
    }  # fmt: skip
    is_bool = isinstance(value, bool)
    return kind in wanted and isinstance(value, wanted[kind]) and is_bool == (kind == "bool")
