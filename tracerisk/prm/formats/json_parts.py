"""What the JSON formats of models have in common."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from tracerisk.prm.trees.gates import Gate


def schema_of(name: str, version: int) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a format, as it is shipped."""
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
