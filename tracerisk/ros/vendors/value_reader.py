"""Read what goes into a driver and comes out of it: fields, constants, references, units."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any

from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import one_of
from tracerisk.ros.vendors.description import REFERENCES, UNITS, Output, Value

VALUE = ("field", "value", "unit", "default", "map")
OUTPUT = ("value", "unit", "map")

_STEP = r"[A-Za-z_]\w*(?:\[\d*\])?"
PATH = re.compile(rf"{_STEP}(?:\.{_STEP})*")
_REFERENCE = re.compile(
    r"\$(?P<name>[a-z_]\w*(?:\.[\w.\[\]]+)?)(?:\[(?P<first>\d+)(?P<part>:(?P<last>\d+)?)?\])?"
    r"(?:\s+(?P<unit>\S+))?"
)


class ValueReader:
    """Reads values and outputs; `known` are the names of state and parameters, as `$name`."""

    def __init__(self, known: Collection[str]) -> None:
        self._known = tuple(known)

    def value(self, entry: YamlMap, key: str, *, is_word: bool = False) -> Value:
        """Return what an interface is given; `is_word`: a plain string is the word itself."""
        given = entry.get(key)
        place, name = entry.key_location(key), entry.name_of(key)
        if not isinstance(given, dict):
            return self._given(entry, key, name, is_word)
        inner = entry.map(key)
        inner.forbid_unknown(VALUE)
        named = [literal for literal in ("field", "value") if literal in inner]
        if len(named) != 1:
            entry.fail(key, "give it either 'field' or 'value'")
        base = (
            self._given(inner, "field", name, False)
            if named == ["field"]
            else Value(name, place, constant=plain_value(inner, "value"))
        )
        if named == ["field"] and not base.paths:
            inner.fail("field", "expected the name of a field, or a list of such")
        return Value(
            name,
            place,
            base.paths,
            base.is_list,
            base.constant,
            _unit(inner),
            plain_value(inner, "default") if "default" in inner else None,
            _map(inner),
        )

    def _given(self, entry: YamlMap, key: str, name: str, is_word: bool) -> Value:
        place = entry.key_location(key)
        given = plain_value(entry, key)
        if is_word and not isinstance(given, str):
            entry.fail(key, "expected a word, or {field: NAME}")
        if isinstance(given, str) and not is_word:
            self._check_source(entry, key, given)
            return Value(name, place, paths=(given,))
        if isinstance(given, list) and given and all(isinstance(item, str) for item in given):
            for item in given:
                self._check_source(entry, key, str(item))
            return Value(name, place, paths=tuple(given), is_list=True)
        if isinstance(given, list) and any(isinstance(item, str) for item in given):
            entry.fail(key, "expected numbers or fields in a list, found both")
        return Value(name, place, constant=given)

    def _check_source(self, entry: YamlMap, key: str, path: str) -> None:
        if not path.startswith("$"):
            check_path(entry, key, path)
        elif path[1:] not in self._known:
            names = [f"${name}" for name in self._known]
            entry.fail(key, f"'{path}' is not known; {one_of(names, path)}")

    def outputs(self, entry: YamlMap, key: str) -> dict[str, Output] | None:
        """Return what the fields of an answer get, None where the key is absent."""
        if key not in entry:
            return None
        outputs = entry.map(key)
        table = {}
        for path in outputs:
            if key != "parameters":
                check_path(outputs, path, path)
            table[path] = self._output(outputs, path)
        return table

    def _output(self, entry: YamlMap, key: str) -> Output:
        value = entry.get(key)
        place, name = entry.key_location(key), entry.name_of(key)
        map_, unit = None, ""
        if isinstance(value, dict):
            inner = entry.map(key)
            inner.forbid_unknown(OUTPUT)
            value = plain_value(inner, "value") if "value" in inner else inner.require("value")
            unit = _unit(inner)
            map_ = _map(inner)
        else:
            value = plain_value(entry, key)
        if not isinstance(value, str) or not value.startswith("$"):
            return Output(name, place, constant=value, map=map_)
        if value.startswith("$$"):
            return Output(name, place, constant=value[1:], map=map_)
        match = _REFERENCE.fullmatch(value)
        if match is None:
            entry.fail(key, f"'{value}' is not a reference; write $NAME, $NAME[0] or $NAME[0:3]")
        reference = match["name"]
        allowed = (*REFERENCES, *self._known)
        if reference.startswith("request."):
            check_path(entry, key, reference.removeprefix("request."))
        elif reference not in allowed:
            named = [f"${text}" for text in allowed]
            entry.fail(key, f"'${reference}' is not known; {one_of(named, '$' + reference)}")
        if match["unit"]:
            unit = match["unit"]
            if unit not in UNITS:
                entry.fail(key, f"unknown unit '{unit}'; {one_of(UNITS, unit)}")
        first = None if match["first"] is None else int(match["first"])
        last = None if match["last"] is None else int(match["last"])
        if first is not None and not match["part"]:
            last = first
        elif last is not None:
            last -= 1
        return Output(name, place, reference=reference, first=first, last=last, unit=unit, map=map_)


def check_path(entry: YamlMap, key: str, path: str) -> None:
    """Raise at a key whose path is none."""
    if not PATH.fullmatch(path):
        entry.fail(key, f"'{path}' is not a field; join names by dots: 'target.pose', 'points[].x'")


def plain_value(entry: YamlMap, key: str) -> Any:  # noqa: RET503 - `fail` raises
    """Return a value that is a number, a string, a truth value, or a list of such."""
    value = entry.require(key)
    if isinstance(value, str):
        return str(value)
    if isinstance(value, bool):
        return value
    if isinstance(value, int | float):
        if isinstance(value, int):
            # Its limits: what no message can hold is not a number of a description.
            entry.number(key, minimum=-(2.0**63), maximum=2.0**64)
        else:
            entry.number(key)
        return value
    if isinstance(value, list):
        for item in value:
            if not isinstance(item, str | bool | int | float):
                entry.fail(key, "expected a list of numbers or strings")
        numbers = [item for item in value if not isinstance(item, str | bool)]
        if numbers and len(numbers) == len(value):
            entry.numbers(key)
        return [str(name) if isinstance(name, str) else name for name in value]
    entry.fail(key, "expected a number, a string, true or false, or a list of such")


def _map(entry: YamlMap) -> dict[str, Any] | None:
    inner = entry.optional_map("map")
    return None if inner is None else {key: plain_value(inner, key) for key in inner}


def _unit(entry: YamlMap) -> str:
    return entry.choice("unit", UNITS, "unit") if "unit" in entry else ""
