"""The scenario lines that would give a controller what it waits for, ready to paste."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from tracerisk.errors import InputError
from tracerisk.ros.needs import Need
from tracerisk.ros.scenario_fields import (
    DURATIONS,
    FLOATS,
    TIMES,
    MessageField,
    fields_of,
    type_of,
)

_SECTIONS = {
    "parameter": "parameters",
    "topic": "publish",
    "service": "services",
    "action": "actions",
    "call": "calls",
    "goal": "calls",
    "frame": "frames",
    "input": "answers",
}
_PARAMETERS: Mapping[str, Any] = {
    "bool": False,
    "integer": 0,
    "double": 0.0,
    "string": "",
    "byte_array": [0],
    "bool_array": [False],
    "integer_array": [0],
    "double_array": [0.0],
    "string_array": [""],
}
_DEEPEST = 5  # of nested messages: what lies deeper has its defaults without being written
_WIDTH = 88
_PLAIN = re.compile(r"[A-Za-z/][\w/.]*")
_YES_OR_NO = re.compile(r"y/n|\byes\b", re.IGNORECASE)
_NO_STRINGS = frozenset({"true", "false", "null", "yes", "no", "on", "off", "nan", "inf"})


def scenario_lines(needs: Iterable[Need], interfaces: Any) -> str:
    """Return the sections of a scenario that meet the needs, with the defaults of their types.

    `interfaces` makes the message classes; a type it does not know is written without fields.
    """
    sections: dict[str, Any] = {}
    for need in needs:
        section = _SECTIONS[need.kind]
        if need.kind == "parameter":
            sections.setdefault(section, {})[need.name] = _PARAMETERS.get(need.type_name, 0.0)
        else:
            sections.setdefault(section, []).append(_entry(need, interfaces))
    names = dict.fromkeys(_SECTIONS.values())
    ordered = {name: sections[name] for name in names if name in sections}
    return "".join(f"{line}\n" for line in _block(ordered, 0))


def _entry(need: Need, interfaces: Any) -> Any:
    try:
        return _ENTRIES[need.kind](need, interfaces)
    except InputError:
        return {_NAME_KEYS.get(need.kind, "name"): need.name}


def _topic(need: Need, interfaces: Any) -> Any:
    if need.type_name == "*":
        return {"topic": need.name, "type": "std_msgs/String", "message": {"data": ""}}
    message = default_fields(interfaces.message(need.type_name))
    return {"topic": need.name, "type": need.type_name, "message": message}


def _service(need: Need, interfaces: Any) -> Any:
    if not need.type_name:
        return {"name": need.name, "reply": {}}
    response = service_parts(interfaces, need.type_name)[1]
    return {"name": need.name, "type": need.type_name, "reply": default_fields(response)}


def _action(need: Need, interfaces: Any) -> Any:
    result = action_parts(interfaces, need.type_name)[0]
    return {
        "name": need.name,
        "type": need.type_name,
        "after": 1.0,
        "status": "succeeded",
        "result": default_fields(result),
    }


def _call(need: Need, interfaces: Any) -> Any:
    request = default_fields(service_parts(interfaces, need.type_name)[0])
    return {"service": need.name, "type": need.type_name, "request": request}


def _sent_goal(need: Need, interfaces: Any) -> Any:
    goal = default_fields(goal_class(interfaces, need.type_name))
    return {"action": need.name, "type": need.type_name, "goal": goal}


def _frame(need: Need, interfaces: Any) -> Any:
    del interfaces
    return {
        "frame": need.name,
        "parent": need.parent,
        "xyz": [0.0, 0.0, 0.0],
        "rpy": [0.0, 0.0, 0.0],
    }


def _answer(need: Need, interfaces: Any) -> Any:
    del interfaces
    return "y" if _YES_OR_NO.search(need.name) else "1"


_ENTRIES = {
    "topic": _topic,
    "service": _service,
    "action": _action,
    "call": _call,
    "goal": _sent_goal,
    "frame": _frame,
    "input": _answer,
}
_NAME_KEYS = {"topic": "topic", "frame": "frame", "call": "service", "goal": "action"}


def service_parts(interfaces: Any, type_name: str) -> tuple[Any, Any]:
    """Return the classes of a service's request and response, of either ROS.

    Raises:
        InputError: no such service is known.
    """
    found = interfaces.service(type_name)
    if hasattr(found, "_request_class"):
        return found._request_class, found._response_class
    return found.Request, found.Response


def action_parts(interfaces: Any, type_name: str) -> tuple[Any, Any]:
    """Return the classes of an action's result and feedback, of either ROS.

    Raises:
        InputError: no such action is known.
    """
    if hasattr(interfaces, "action"):
        found = interfaces.action(type_name)
        return found.Result, found.Feedback
    return interfaces.message(f"{type_name}Result"), interfaces.message(f"{type_name}Feedback")


def goal_class(interfaces: Any, type_name: str) -> Any:
    """Return the class of an action's goal, of either ROS.

    Raises:
        InputError: no such action is known.
    """
    if hasattr(interfaces, "action"):
        return interfaces.action(type_name).Goal
    return interfaces.message(f"{type_name}Goal")


def default_fields(message_class: Any, depth: int = 1) -> dict[str, Any]:
    """Return the fields of a message with their defaults, as a scenario writes them.

    Stamps are `now`, and a quaternion turns nothing, where ROS 1 has one that is none.
    """
    is_turn = type_of(message_class) == "geometry_msgs/Quaternion"
    found = {}
    for field in fields_of(message_class):
        if field.message is not None and not field.is_array and depth >= _DEEPEST:
            continue
        if field.name == "seq" and type_of(message_class) == "std_msgs/Header":
            continue
        found[field.name] = 1.0 if is_turn and field.name == "w" else _default(field, depth)
    return found


def _default(field: MessageField, depth: int) -> Any:
    if field.is_array:
        return [_scalar(field, depth) for _ in range(field.length or 0)]
    return _scalar(field, depth)


def _scalar(field: MessageField, depth: int) -> Any:
    if field.base in TIMES:
        return "now"
    if field.base in DURATIONS or field.base in FLOATS:
        return 0.0
    if field.message is not None:
        return default_fields(field.message, depth + 1)
    if field.base == "bool":
        return False
    return "" if field.base in ("string", "wstring") else 0


def _block(value: Mapping[str, Any], indent: int) -> list[str]:
    lines = []
    for key, inner in value.items():
        lines += _keyed(f"{' ' * indent}{_text(key)}:", inner, indent + 2)
    return lines


def _keyed(head: str, value: Any, indent: int) -> list[str]:
    flow = _flow(value)
    is_section = indent == 2
    if not is_section and len(head) + 1 + len(flow) <= _WIDTH:
        return [f"{head} {flow}"]
    if isinstance(value, dict) and value:
        return [head, *_block(value, indent)]
    if isinstance(value, list) and any(isinstance(item, dict) for item in value):
        lines = [head]
        for item in value:
            inner = _block(item, indent + 2)
            lines += [f"{' ' * indent}- {inner[0].lstrip()}", *inner[1:]]
        return lines
    return [f"{head} {flow}"]


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        pairs = ", ".join(f"{_text(key)}: {_flow(each)}" for key, each in value.items())
        return f"{{{pairs}}}"
    if isinstance(value, list):
        return "[" + ", ".join(_flow(each) for each in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return _text(value) if isinstance(value, str) else repr(value)


def _text(text: str) -> str:
    if _PLAIN.fullmatch(text) and text.lower() not in _NO_STRINGS:
        return text
    quoted = text.replace("'", "''")
    return f"'{quoted}'"
