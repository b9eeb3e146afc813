"""The units of a driver's fields, and its answer, as their names say."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any

from tracerisk.ros.drafts.drivers.asked import Part
from tracerisk.ros.messages.fields import snake_case

_UNITS = {
    "angle": (("deg", re.compile("deg|°")), ("rad", re.compile("rad"))),
    "length": (
        ("mm", re.compile(r"(^|[\W_])mm($|[\W_])|millimet")),
        ("cm", re.compile(r"(^|[\W_])cm($|[\W_])|centimet")),
        ("m", re.compile(r"(^|[\W_])m($|[\W_])|met(er|re)")),
    ),
}
_SUCCESS = re.compile(r"succ|ok|done|res(ult)?$|(^|_)(ret|reached|finished|accepted)(_|$)")
_CODE = re.compile(r"(^|_)(ret|res|result|code|err(or)?(_?(code|id|no))?|status)(_|$)")
_TEXT = re.compile(r"mess|msg|text|reason|info|error")


def units_of_fields(
    parts: tuple[Part, ...], roles: Mapping[str, Any], effect: str, doubted: Collection[str]
) -> tuple[dict[str, str], str]:
    """Return the units of a description, and in words what of them is assumed."""
    keys = (key for key in ("joints", "pose", "position", "width") if key in roles)
    role = roles.get(next(keys, ""))
    paths = role if isinstance(role, list) else [role]
    used = [part for part in parts if part.path in paths and part.field.message is None]
    if not used or (effect == "grip" and "width" not in roles):
        return {}, ""
    words = " ".join(part.words for part in used)
    units: dict[str, str] = {}
    assumed: list[str] = []
    large: list[str] = []
    for dimension, plain, other, is_there in (
        ("length", "m", "mm", "joints" not in roles),
        ("angle", "rad", "deg", effect == "move" and "position" not in roles),
    ):
        written = next((unit for unit, text in _UNITS[dimension] if text.search(words)), "")
        unit = written or (other if dimension in doubted else plain)
        if is_there and unit != plain:
            units[dimension] = unit
        if is_there and not written:
            assumed.append(unit)
            large += [plain] if dimension in doubted else []
    if not assumed:
        return units, ""
    why = f" (some numbers are too large for {' and '.join(large)})" if large else ""
    return units, f" in {' and '.join(assumed)}{why}"


def guessed_answer(reply: Mapping[str, Any], codes: dict[str, Any]) -> dict[str, Any]:
    """Return how an answer is filled; the values of its number go into `codes`."""
    answer: dict[str, Any] = {}
    for name, value in reply.items():
        called = snake_case(name)
        if isinstance(value, bool):
            answer[name] = "$success" if _SUCCESS.search(called) else value
        elif isinstance(value, int) and not codes and _CODE.search(called):
            answer[name] = "$code"
            codes |= {"succeeded": value, "failed": value - 1 if value > 0 else value + 1}
        elif isinstance(value, str) and value:
            # The word of success that the code knows is no answer of a motion that failed.
            answer[name] = {"value": "$success", "map": {"true": value, "else": ""}}
        elif isinstance(value, str) and _TEXT.search(called):
            answer[name] = "$message"
        elif isinstance(value, int | float):
            answer[name] = value
        elif isinstance(value, Mapping) and value.keys() == {"data"}:
            # A message of ROS in the place of its only value.
            inner = guessed_answer({name: value["data"]}, codes)
            answer |= {f"{name}.data": output for output in inner.values()}
    return answer
