"""A derivation as plain data for `--json`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from tracerisk.adder.figures.derivation import FunctionDerivation
from tracerisk.common.text.finite import finite

SCHEMA = "tracerisk-derivation"
VERSION = 1


def derivation_data(derivation: FunctionDerivation) -> dict[str, Any]:
    """Return the derivation as plain JSON values, keys as the fields are named.

    An infinite number (the hazard of what is certain to fail) is `None`, JSON's null.
    """
    plain: dict[str, Any] = finite(asdict(derivation))
    return {"schema": SCHEMA, "version": VERSION, **plain}
