"""Texts of JSON with what a callback looks up in them."""

from __future__ import annotations

import json
from typing import Any

from tracerisk.errors import Location
from tracerisk.instrument.source.literals.answers import ordered_answers, without_emergency
from tracerisk.instrument.source.literals.json_shapes import JsonShape, json_shape
from tracerisk.ros.drafts.named_numbers import named_number, units_of
from tracerisk.ros.drafts.posture_numbers import numbers_of
from tracerisk.ros.drafts.said_around import said_in_callback
from tracerisk.ros.drafts.usable_values import UsableValues

_MOST_IN_TURN = 6  # texts, each with another of the words that the code knows


def json_texts(place: Location | None, values: UsableValues) -> tuple[str, ...]:
    """Return texts of JSON that the callback at `place` reads; () where it reads none.

    Where it knows several words for one key, there is one text for each of them.
    """
    shape = json_shape(place)
    if shape is None or not (shape.keys or shape.item):
        return ()
    said = said_in_callback(place)
    made = _value(shape, "", values, said)
    for name, inner in shape.keys.items():
        words = _words(inner)
        if len(words) > 1 and isinstance(made, dict):
            return tuple(_text({**made, name: word}) for word in words[:_MOST_IN_TURN])
    return (_text(made),)


def _words(shape: JsonShape) -> tuple[str, ...]:
    texts = [value for value in shape.values if isinstance(value, str)]
    return without_emergency(ordered_answers(texts))


def _value(
    shape: JsonShape, name: str, values: UsableValues, said: str, around: tuple[JsonShape, ...] = ()
) -> Any:
    if any(shape is outer for outer in around):
        return []  # the code keeps what comes within itself
    around = (*around, shape)
    if shape.keys:
        return {key: _value(inner, key, values, said, around) for key, inner in shape.keys.items()}
    units = units_of(name, said)
    if not shape.is_number:
        listed = numbers_of(name, None, values.posture, values.pose, units)
        if listed and (shape.item is not None or not shape.values):
            return listed
    if shape.item is not None:
        return [_value(shape.item, name, values, said, around)]
    if words := _words(shape):
        return words[0]
    number = named_number(name, units, values.reach)
    if number is not None:
        return number
    for known in (
        *shape.values,
        *(default for default in shape.defaults if default or default == 0),
    ):
        return known
    return 0.1 if shape.is_number else values.text(name, ()) or 1


def _text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
