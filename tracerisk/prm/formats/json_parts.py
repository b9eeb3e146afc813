"""What the JSON formats of models have in common."""

from __future__ import annotations

import json
import re
from fractions import Fraction
from typing import Any

from tracerisk.prm.formats.element import Element
from tracerisk.prm.trees.gates import Gate, GateKind

# Bounded, for Fraction("1e999999999") would build a number of a thousand million digits.
_FRACTION = re.compile(r"\d{1,40}(?:/\d{1,40}|\.\d{1,40})?")


def schema_of(name: str, version: int) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a format, as it is shipped."""
    from importlib.resources import files  # with temporary files, archives and all

    text = files("tracerisk.prm.formats").joinpath(f"schemas/{name}-{version}.json")
    schema: dict[str, Any] = json.loads(text.read_text(encoding="utf-8"))
    return schema


def gate_to_json(gate: Gate, least: str, most: str) -> dict[str, Any]:
    """Return a gate as JSON values; `least` and `most` are the keys of its two numbers."""
    written: dict[str, Any] = {
        "name": gate.name,
        "type": gate.kind.value,
        "inputs": list(gate.inputs),
    }
    if gate.k is not None:
        written[least] = gate.k
    if gate.most is not None:
        written[most] = gate.most
    return written


def read_gate(element: Element, least: str, most: str) -> Gate:
    """Return the gate that an element states; `least` and `most` as in `gate_to_json`."""
    fields = element.fields(("name", "type", "inputs"), optional=(least, most))
    kinds = {kind.value: kind for kind in GateKind}
    return Gate(
        name=fields["name"].string(),
        kind=kinds[fields["type"].choice(kinds)],
        inputs=fields["inputs"].each(Element.string),
        k=fields[least].integer() if least in fields else None,
        most=fields[most].integer() if most in fields else None,
    )


def read_fraction(element: Element, examples: str) -> Fraction:
    """Return the fraction that a text of an element states; `examples` are for messages."""
    written = element.string()
    if not _FRACTION.fullmatch(written):
        element.fail(f"is '{written}'; expected a fraction such as {examples}")
    try:
        return Fraction(written)
    except ZeroDivisionError:
        element.fail(f"is '{written}', a division by zero")
