"""Logic expressions of OpenPRA: gates out of nested objects, and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.formats.element import Element
from tracerisk.prm.other_models.formats.open_psa.rewriting import Form, accepted_form, form_inputs
from tracerisk.prm.other_models.logic.checks import suggestion
from tracerisk.prm.other_models.logic.model import GateDefinition
from tracerisk.prm.trees.gates import Gate, GateKind, check_gate

_NO_OPERATIONS = ("cardinality", "iff", "imply", "inhibit", "transfer")
OPERATIONS = {kind.value: kind for kind in GateKind if kind.value not in _NO_OPERATIONS}
GREATEST_DEPTH = 200
LIMIT = 1_000_000
"""The most operations that a tree may be written as."""


def read_logic(
    top: Element, name: str, found: Mapping[str, str]
) -> list[tuple[Gate, bool, Element]]:
    """Return the gates of an expression, whether each is nested, and its element.

    `name` is that of the top; a gate without a name of its own is `g#1`, `g#2`, in the order in
    which they begin, where `g` is the innermost gate above it that has one.
    Raises ModelError, with the path and the place, for what is not an expression.
    """
    gates: list[tuple[Gate, bool, Element] | None] = []
    counts = {name: 0}

    def visit(element: Element, owner: str, depth: int) -> str:
        if depth > GREATEST_DEPTH:
            element.fail(f"expressions nest more than {GREATEST_DEPTH} deep; flatten the model")
        parts = element.entries()
        if "event" in parts:
            element.fields({"event"})
            return _event(parts["event"], found)
        place = len(gates)
        gates.append(None)
        own, nested = owner, False
        if place and "name" not in parts:
            counts[owner] += 1
            own, nested = f"{owner}#{counts[owner]}", True
        elif place:
            owner = own = parts["name"].string()
            counts[owner] = 0
        gate = _gate(element, own, lambda below: visit(below, owner, depth + 1))
        gates[place] = (gate, nested, element)
        return own

    if "event" in top.entries():
        top.fields({"event"}, optional={"name"})
        event = _event(top.entries()["event"], found)
        return [(Gate(name, GateKind.TRANSFER, (event,)), False, top)]
    visit(top, name, 0)
    return [gate for gate in gates if gate is not None]


def _event(element: Element, found: Mapping[str, str]) -> str:
    name = element.string()
    if name not in found:
        element.fail(f"'{name}' is not an event or fault tree; {suggestion(found, name)}")
    return found[name]


def _gate(element: Element, name: str, visit: Callable[[Element], str]) -> Gate:
    parts = element.entries()
    if "op" not in parts:
        element.fail("'op' or 'event' is missing")
    kind = OPERATIONS[parts["op"].choice(OPERATIONS)]
    k = None
    if kind is GateKind.NOT:
        fields = element.fields({"op", "arg"}, optional={"name"})
        inputs: tuple[str, ...] = (visit(fields["arg"]),)
    else:
        required = {"op", "args"} | ({"k"} if kind is GateKind.ATLEAST else set())
        fields = element.fields(required, optional={"name"})
        inputs = fields["args"].each(visit)
        if not inputs:
            fields["args"].fail("is empty; give at least one argument")
        if kind is GateKind.ATLEAST:
            k = fields["k"].integer()
    gate = Gate(name, kind, inputs, k)
    try:
        check_gate(gate)
    except ModelError as error:
        element.fail(error.message)
    return gate


class LogicWriter:
    """Writes gates as nested expressions; a gate that feeds several is written in each."""

    def __init__(self, gates: Mapping[str, GateDefinition]) -> None:
        self._gates = gates
        self._counts: dict[str, int] = {}
        self._sizes: dict[str, tuple[int, int]] = {}
        self._written = 0

    def top(self, name: str, tree: str) -> dict[str, Any]:
        """Return the expression of the top gate of a fault tree.

        Raises TooLargeError when it is too large, written out.
        """
        self._check_size(name)
        self._counts = {name: 0}
        written = self._form(accepted_form(self._gates[name].gate), name)
        # A top that only hands on another gate is written as that gate, by its own name.
        written.pop("name", None)
        if "event" in written:
            # The engine takes no event for a top.
            written = _operation(written)
        return written if name == tree else {"name": name, **written}

    def _gate(self, name: str, owner: str) -> dict[str, Any]:
        definition = self._gates[name]
        form = accepted_form(definition.gate)
        if form.kind is GateKind.TRANSFER:
            return self._input(form.inputs[0], owner)
        if definition.nested and name == f"{owner}#{self._counts[owner] + 1}":
            self._counts[owner] += 1
            return self._form(form, owner)
        self._counts[name] = 0
        return {"name": name, **self._form(form, name)}

    def _form(self, form: Form, owner: str) -> dict[str, Any]:
        if form.kind is GateKind.TRANSFER:
            return self._input(form.inputs[0], owner)
        inputs = _apart([self._input(item, owner) for item in form.inputs])
        if form.kind is GateKind.NOT:
            return {"op": "not", "arg": inputs[0]}
        written: dict[str, Any] = {"op": form.kind.value}
        if form.k is not None:
            written["k"] = form.k
        return written | {"args": inputs}

    def _input(self, input_: str | Form, owner: str) -> dict[str, Any]:
        if isinstance(input_, Form):
            self._counts[owner] += 1
            return self._form(input_, owner)
        if input_ not in self._gates:
            return {"event": input_}
        return self._gate(input_, owner)

    def _check_size(self, top: str) -> None:
        """Check how many operations a gate takes, written out, and how deep they nest."""
        sizes = self._sizes
        stack = [top]
        while stack:
            name = stack[-1]
            names = list(form_inputs(accepted_form(self._gates[name].gate)))
            below = [text for text in names if text in self._gates]
            waiting = [text for text in below if text not in sizes]
            if waiting:
                stack += waiting
                continue
            stack.pop()
            sizes[name] = (
                1 + sum(sizes[key][0] for key in below),
                1 + max((sizes[key][1] for key in below), default=0),
            )
        size, depth = sizes[top]
        self._written += size
        if self._written > LIMIT:
            raise TooLargeError(
                f"gate '{top}': OpenPRA repeats a gate for each of its uses, here more than "
                f"{LIMIT} times in all; use another format"
            )
        if depth > GREATEST_DEPTH // 2:
            raise TooLargeError(
                f"gate '{top}' has {depth} levels of gates below it, which OpenPRA nests; "
                f"allowed: {GREATEST_DEPTH // 2}; use another format"
            )


def _operation(event: dict[str, Any]) -> dict[str, Any]:
    """Return an operation that is the event."""
    return {"op": GateKind.OR.value, "args": [event]}


def _apart(inputs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return arguments with an event that gates hand on twice as one event and operations."""
    seen: set[str] = set()
    apart = []
    for part in inputs:
        event = part.get("event")
        apart.append(_operation(part) if event in seen else part)
        if event is not None:
            seen.add(event)
    return apart
