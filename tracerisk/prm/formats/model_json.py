"""The whole hybrid model as JSON: written the same way each time, read with clear errors."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Mapping
from fractions import Fraction
from typing import Any, NoReturn, TypeVar

from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.fault_tree import BasicEvent, FaultTree, Gate, GateKind
from tracerisk.prm.hybrid import FunctionState, HybridModel, NextStep, Parameter

SCHEMA = "tracerisk-hybrid-model"
VERSION = 1

# Bounded, for Fraction("1e999999999") would build a number of a thousand million digits.
_WEIGHT = re.compile(r"\d{1,40}(?:/\d{1,40}|\.\d{1,40})?")

T = TypeVar("T")


def model_data(model: HybridModel) -> dict[str, Any]:
    """Return the model as plain JSON values; weights of `next` are exact fractions, as strings."""
    return {
        "schema": SCHEMA,
        "version": VERSION,
        "name": model.name,
        "entry": model.entry,
        "parameters": [{"name": p.name, "theta": p.theta} for p in model.parameters],
        "states": [_state_to_json(state) for state in model.states],
        "latent": list(model.latent),
    }


def dumps(model: HybridModel) -> str:
    """Return the model as JSON text: sorted keys, floats that read back to the same bits."""
    text = json.dumps(
        model_data(model), indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False
    )
    return text + "\n"


def loads(text: str, file: str) -> HybridModel:
    """Read a model from JSON text; `file` is its name in messages.

    Raises ModelError with the position (line and column, or the path of the element) and what
    is allowed, when the text is no JSON, is of another schema or version, lacks a key or has an
    unknown one, or when the model does not hold together (see HybridModel and FaultTree).
    """
    place = Location(file)
    try:
        data = json.loads(text, object_pairs_hook=_without_duplicates, parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise ModelError(
            f"is not valid JSON: {error.msg}; is the file whole?",
            Location(file, error.lineno, error.colno),
        ) from error
    except (ValueError, RecursionError) as error:
        detail = error.message if isinstance(error, ModelError) else "a number or nesting too large"
        raise ModelError(f"cannot be read: {detail}", place) from error
    try:
        return _model(_Element(data, ""))
    except ModelError as error:
        raise ModelError(error.message, place) from error


def _state_to_json(state: FunctionState) -> dict[str, Any]:
    return {
        "name": state.name,
        "call_sequence": state.call_sequence,
        "fault_tree": {
            "top": state.tree.top,
            "gates": [_gate_to_json(gate) for gate in state.tree.gates],
            "basic_events": [
                {"name": event.name, "parameter": event.parameter} for event in state.tree.events
            ],
        },
        "probabilities": dict(state.probabilities),
        "next": [{"target": step.target, "weight": str(step.weight)} for step in state.next],
    }


def _gate_to_json(gate: Gate) -> dict[str, Any]:
    written = {"name": gate.name, "type": gate.kind.value, "inputs": list(gate.inputs)}
    return written if gate.k is None else written | {"k": gate.k}


def _model(top: _Element) -> HybridModel:
    _check_version(top.entries())
    found = top.fields({"schema", "version", "name", "entry", "parameters", "states", "latent"})
    return HybridModel(
        name=found["name"].string(),
        entry=found["entry"].string(),
        states=found["states"].each(_state),
        parameters=found["parameters"].each(_parameter),
        latent=found["latent"].each(_Element.string),
    )


def _check_version(found: Mapping[str, _Element]) -> None:
    """Raise ModelError at another schema or version, whatever else such a document holds."""
    if "schema" in found and found["schema"].value != SCHEMA:
        found["schema"].fail(f"is {found['schema'].value!r}; expected '{SCHEMA}'")
    if "version" not in found:
        return
    version = found["version"].value
    if version == 0 and not isinstance(version, bool):
        found["version"].fail(
            f"is 0; this version of tracerisk reads {VERSION}: build the model again "
            "(version 0 does not tell whether failures of redundant units stay hidden)"
        )
    if version != VERSION or isinstance(version, bool):
        found["version"].fail(
            f"is {version!r}; this version of tracerisk reads {VERSION}: build the model again"
        )


def _parameter(element: _Element) -> Parameter:
    found = element.fields({"name", "theta"})
    return Parameter(found["name"].string(), found["theta"].number())


def _state(element: _Element) -> FunctionState:
    found = element.fields({"name", "call_sequence", "fault_tree", "probabilities", "next"})
    return FunctionState(
        name=found["name"].string(),
        call_sequence=found["call_sequence"].integer(),
        tree=_tree(found["fault_tree"]),
        probabilities={
            name: value.number() for name, value in found["probabilities"].entries().items()
        },
        next=found["next"].each(_step),
    )


def _step(element: _Element) -> NextStep:
    found = element.fields({"target", "weight"})
    written = found["weight"].string()
    if not _WEIGHT.fullmatch(written):
        found["weight"].fail(f'is \'{written}\'; expected a fraction such as "9/10" or "0.9"')
    try:
        weight = Fraction(written)
    except ZeroDivisionError:
        found["weight"].fail(f"is '{written}', divided by zero")
    return NextStep(found["target"].string(), weight)


def _tree(element: _Element) -> FaultTree:
    found = element.fields({"top", "gates", "basic_events"})
    top = found["top"].string()
    gates = found["gates"].each(_gate)
    events = found["basic_events"].each(_event)
    try:
        return FaultTree(top, gates, events)
    except ModelError as error:
        element.fail(error.message)


def _gate(element: _Element) -> Gate:
    found = element.fields({"name", "type", "inputs"}, optional={"k"})
    kinds = {kind.value: kind for kind in GateKind}
    kind = found["type"].string()
    if kind not in kinds:
        found["type"].fail(f"is '{kind}'; {one_of(kinds, kind)}")
    return Gate(
        name=found["name"].string(),
        kind=kinds[kind],
        inputs=found["inputs"].each(_Element.string),
        k=found["k"].integer() if "k" in found else None,
    )


def _event(element: _Element) -> BasicEvent:
    found = element.fields({"name", "parameter"})
    return BasicEvent(found["name"].string(), found["parameter"].string())


class _Element:
    """A value of the document and its path, `states[2].next[0].weight`, for messages."""

    def __init__(self, value: Any, path: str) -> None:
        self.value = value
        self._path = path

    def fail(self, message: str) -> NoReturn:
        raise ModelError(f"{self._path or 'the document'}: {message}")

    def entries(self) -> dict[str, _Element]:
        if not isinstance(self.value, Mapping):
            self.fail(f"expected an object, found {_kind(self.value)}")
        lead = f"{self._path}." if self._path else ""
        return {key: _Element(value, f"{lead}{key}") for key, value in self.value.items()}

    def fields(
        self, required: Collection[str], *, optional: Collection[str] = ()
    ) -> dict[str, _Element]:
        entries = self.entries()
        for key in sorted(required):
            if key not in entries:
                self.fail(f"'{key}' is missing")
        for key in entries:
            if key not in required and key not in optional:
                self.fail(f"unknown key '{key}'; {one_of({*required, *optional}, key)}")
        return entries

    def each(self, read: Callable[[_Element], T]) -> tuple[T, ...]:
        if not isinstance(self.value, list):
            self.fail(f"expected a list, found {_kind(self.value)}")
        return tuple(
            read(_Element(value, f"{self._path}[{index}]"))
            for index, value in enumerate(self.value)
        )

    def string(self) -> str:
        if not isinstance(self.value, str):
            self.fail(f"expected a string, found {_kind(self.value)}")
        return self.value

    def integer(self) -> int:
        if isinstance(self.value, bool) or not isinstance(self.value, int):
            self.fail(f"expected a whole number, found {_kind(self.value)}")
        return self.value

    def number(self) -> float:
        """Return a probability; out of [0, 1] fails here, where the element is known."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | float):
            self.fail(f"expected a number, found {_kind(self.value)}")
        if not 0 <= self.value <= 1:
            self.fail(f"probability {self.value!r} is outside [0, 1]")
        return float(self.value)


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise ModelError(f"the key '{key}' stands twice in one object; remove one")
        found[key] = value
    return found


def _no_constant(text: str) -> NoReturn:
    raise ModelError(f"{text} is no number of a model; give a finite one")


def _kind(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"the number {value!r}"
    if isinstance(value, str):
        return f"the string '{value}'"
    return "a list" if isinstance(value, list) else "an object"
