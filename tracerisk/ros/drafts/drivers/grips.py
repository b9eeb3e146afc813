"""What of an unknown driver moves a gripper: a switch, a width, an opening."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from tracerisk.ros.drafts.drivers.asked import Asked, Found, Part, is_of_others, is_percent

_GRIPS = re.compile(r"grip|finger|(^|_)(hand|claw|jaws?|vacuum|suction|pump)(_|$)")
_OPENS = re.compile(r"open|release|(^|_)off(_|$)")
_CLOSES = re.compile(
    r"clos|grasp|grip|hold|enable|activ|suck|suction|vacuum|(^|_)(on|data|state)(_|$)"
)
_WIDTH = re.compile(r"width|opening|aperture|distance|gap")
_GRIP_PLACE = re.compile(r"(^|_)(pos|position|stroke|percent|value|data|target|angle)")


def grip_of(asked: Asked, parts: tuple[Part, ...]) -> Found | None:
    """Return how a request moves the gripper; None where its name and fields do not show it."""
    called = asked.called
    if not _GRIPS.search(called) or is_of_others(called):
        return None
    if not parts:
        if bool(_OPENS.search(called)) == bool(re.search(r"clos|grasp|(^|_)on(_|$)", called)):
            return None
        is_open = bool(_OPENS.search(called))
        return "grip", {"open": is_open}, "opens the gripper" if is_open else "closes the gripper"
    for part in parts:
        if part.field.base == "bool" and not part.field.is_array:
            is_open = bool(_OPENS.search(part.name))
            if not is_open and part.name == "data":
                is_open = bool(_OPENS.search(called))
            if is_open:
                return "grip", {"open": part.path}, f"`{part.path}` opens the gripper"
            if _CLOSES.search(part.name):
                closes = {"field": part.path, "map": {"true": False, "false": True}}
                return "grip", {"open": closes}, f"`{part.path}` closes the gripper"
    for part in parts:
        if part.is_number and _WIDTH.search(part.name):
            return "grip", {"width": part.path}, f"`{part.path}` is the gripper's width"
    for part in parts:
        if part.is_number and _GRIP_PLACE.search(part.name):
            role = {"field": part.path, "unit": "percent"} if is_percent(part) else part.path
            words = "in percent" if is_percent(part) else _ends_words(asked, part.name)
            return "grip", {"position": role}, f"`{part.path}` is the gripper's opening, {words}"
    for part in parts:
        names = asked.elements.get(part.field.name, ()) if part.field.is_array else ()
        for index, name in enumerate(names):
            if _GRIP_PLACE.search(name) or _WIDTH.search(name):
                path, words = f"{part.path}[{index}]", _ends_words(asked, name)
                return "grip", {"position": path}, f"`{path}` is the gripper's opening, {words}"
    return None


def _ends_words(asked: Asked, name: str) -> str:
    largest, opens_at_0 = asked.largest.get(name, (1.0, False))
    if opens_at_0:
        return f"from 0, open, to {largest:g}"
    return f"from 0, closed, to {largest:g}"


def ends_of(asked: Asked, roles: Mapping[str, Any]) -> dict[str, float]:
    """Return the numbers of a gripper's ends where the source says them; {} for 0 and 1."""
    path = roles.get("position")
    if not isinstance(path, str):
        return {}
    list_name, _, index = path.rpartition(".")[2].partition("[")
    name = asked.elements[list_name][int(index[:-1])] if index else list_name
    if name not in asked.largest:
        return {}
    largest, opens_at_0 = asked.largest[name]
    return {"closed": largest, "open": 0.0} if opens_at_0 else {"closed": 0.0, "open": largest}
