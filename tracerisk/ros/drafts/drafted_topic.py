"""The messages that a scenario could publish on a topic."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from tracerisk.instrument.source.literals.answers import ordered_answers, without_emergency
from tracerisk.instrument.source.literals.compared_values import Compared, compared_in_callback
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.drafts.draft import Lack, Made
from tracerisk.ros.drafts.json_texts import json_texts
from tracerisk.ros.drafts.pictures.drafted_pictures import PICTURES, picture
from tracerisk.ros.drafts.pictures.seen_in_pictures import seen_in_pictures, takes_pixels
from tracerisk.ros.drafts.said_around import said_in_callback
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.drafts.user_input.dragged_markers import FEEDBACK, dragged_in_turn
from tracerisk.ros.drafts.user_input.game_pad import pressed_in_turn
from tracerisk.ros.messages.fields import fields_of, known_constants

_SENSOR = re.compile(r"^(sensor_msgs/(?!JointState|Joy)|nav_msgs/Odometry|geometry_msgs/Wrench)")
_COMMAND = re.compile(r"std_msgs/(Bool|Empty|String|U?Int\d+)$")
_EACH_S = 10.0  # between two commands of which a controller knows several
_FEW_WORDS = 6  # of more, keys of a keyboard, each moves a little
_MOST_WORDS = 16
_SHORT_S = 2.0  # between two of those
_PRESSED_S = 1.0  # for how long each button of a game pad is pressed
_ALARM = re.compile(
    r"(^|[/_])(bumper|cliff|wheel_drop|e_?stop|emergency\w*|collisions?|alarms?|faults?)s?([/_]|$)",
    re.IGNORECASE,
)


def drafted_topic(lack: Lack) -> Made:
    """Return the messages that a scenario could publish on a topic to which nobody does."""
    need = lack.need
    if need.type_name == "*":
        unknown = {"topic": need.name, "type": "std_msgs/String", "message": {"data": ""}}
        return unknown, "its type is not known"
    if _ALARM.search(need.name) and not need.type_name.startswith("std_msgs/"):
        return None, "an alarm, which no draft gives"
    made, values = lack.interfaces.message(need.type_name), lack.values
    compared = compared_in_callback(lack.place, constants=known_constants(made))
    said, comments = said_in_callback(lack.place), lack.comments("msg")
    message = values.fields(made, compared, need.name, said, comments)
    entry: dict[str, Any] = {"topic": need.name, "type": need.type_name}
    several: tuple[str | bool, ...] = ()
    texts = json_texts(lack.place, values) if need.type_name == "std_msgs/String" else ()
    if texts:
        several, message = texts if len(texts) > 1 else (), {"data": texts[0]}
    elif need.type_name == "std_msgs/String":
        known = without_emergency(ordered_answers(compared.texts(("data",))))
        several = known[:_MOST_WORDS]
    elif need.type_name == "std_msgs/Bool" and message["data"]:
        several = compared.truths(("data",))
    if need.type_name == "sensor_msgs/Joy":
        held = pressed_in_turn(message, compared)
        timing = {"at": 1.0, "rate": 1 / _PRESSED_S, "count": len(held)}
        entry = {**entry, "messages": held, **timing}
        return entry, "the sticks moved to and fro, without a button and then with each"
    if need.type_name == FEEDBACK:
        used = list(dragged_in_turn(message, values.shown_markers(need.name)))
        if used:
            entry = sent_in_turn(entry, used)
            return entry, "each marker is dragged, and each entry of its menu chosen, in turn"
    field, in_turn = ("data", several) if several else _values_in_turn(need, message, compared)
    if len(in_turn) > 1:
        entry = sent_in_turn(entry, [{**message, field: item} for item in in_turn])
        return entry, "the values that the code knows, in turn"
    if _SENSOR.match(need.type_name):
        words = _typed_text(need.type_name, compared.values, values)
        if need.type_name in PICTURES and (
            seen_in_pictures(lack.place) is not None or takes_pixels(lack.place)
        ):
            parts, frame = [field.name for field in fields_of(made)], values.robot.base_link
            message = picture(need.type_name, parts, frame, need.name, is_large=True)
        return {**entry, "rate": 10.0, "until": 60.0, "message": message}, words
    # A command finds that what was seen has come already.
    after = 2.0 if _COMMAND.match(need.type_name) else 1.0
    entry = {**entry, "after": after, "message": message}
    if texts:
        return entry, "JSON with what the code looks up"
    return entry, _typed_text(need.type_name, compared.values, values)


def sent_in_turn(entry: Mapping[str, Any], commands: Sequence[Any]) -> dict[str, Any]:
    """Return the entry of a topic with several commands, each with time to be carried out."""
    rate = 1 / (_EACH_S if len(commands) <= _FEW_WORDS else _SHORT_S)
    kept = {key: entry[key] for key in ("topic", "type") if key in entry}
    return {**kept, "messages": list(commands), "at": 1.0, "rate": rate, "count": len(commands)}


def _values_in_turn(
    need: Need, message: Mapping[str, Any], compared: Compared
) -> tuple[str, Sequence[str | int]]:
    """Return the field of a command that has several known values, and these; none for sensors."""
    if _SENSOR.match(need.type_name):
        return "", ()
    for name, now in message.items():
        known: Sequence[str | int] = ()
        if isinstance(now, str):
            known = without_emergency(ordered_answers(compared.texts((name,))))
        elif type(now) is int:
            known = [number for number in compared.numbers((name,)) if isinstance(number, int)]
        if len(known) > 1 and now in known:
            return name, known[:_MOST_WORDS]
    return "", ()


def _typed_text(type_name: str, compared: Any, values: UsableValues) -> str:
    name = values.robot.name
    if re.search(r"Joint", type_name):
        return f"joints of {name}, a little away from where it begins"
    if re.search(r"Pose|Point|Transform|Detection|Marker", type_name):
        return f"a pose that {name} reaches"
    return "as the code compares it" if compared else "a value of its type"
