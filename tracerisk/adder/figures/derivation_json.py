"""A derivation as plain data for `--json`."""

from __future__ import annotations

import math
from dataclasses import asdict
from enum import Enum
from typing import Any

from tracerisk.adder.figures.derivation import FunctionDerivation

SCHEMA = "tracerisk-derivation"
VERSION = 1


def derivation_data(derivation: FunctionDerivation) -> dict[str, Any]:
    """Return the derivation as plain JSON values, keys as the fields are named.

    A number that is infinite (of what surely fails) is `None`, JSON's null.
    """
    plain: dict[str, Any] = _plain(asdict(derivation))
    return {"schema": SCHEMA, "version": VERSION, **plain}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
