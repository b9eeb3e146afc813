"""`--explain FUNCTION`: where the figures of a function come from, as text or as JSON."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tracerisk.adder.figures.derivation import FunctionDerivation
    from tracerisk.config import Settings
    from tracerisk.hardware.model import Hardware
    from tracerisk.pipeline import Annotated


def explained(
    options: argparse.Namespace, annotated: Annotated, hardware: Hardware, settings: Settings
) -> FunctionDerivation | None:
    """Return the derivation that was asked for, if any.

    Raises InputError, before anything is written, for an unknown function.
    """
    if options.explain is None:
        return None
    from tracerisk import pipeline

    return pipeline.explain(annotated, hardware, settings, options.explain)


def derivation_json(derivation: FunctionDerivation | None) -> dict[str, Any]:
    """Return what `--json` has of it: nothing, or the key `derivation`."""
    if derivation is None:
        return {}
    from tracerisk.adder.figures.derivation_json import derivation_data

    return {"derivation": derivation_data(derivation)}


def print_derivation(derivation: FunctionDerivation | None) -> None:
    """Print it on standard output, where it was asked for."""
    if derivation is None:
        return
    from tracerisk.report.explain import render_derivation

    sys.stdout.buffer.write(render_derivation(derivation).encode())
    sys.stdout.flush()
