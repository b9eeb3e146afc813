"""`--explain FUNCTION`: where the figures of a function come from, as text or as JSON."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from tracerisk.common.text.printable import escaped

if TYPE_CHECKING:
    from tracerisk.adder.figures.derivation import FunctionDerivation
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.config import Settings
    from tracerisk.pipeline.annotate import Annotated
    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.prm.hybrid.hybrid import HybridModel


def explained(
    options: argparse.Namespace, annotated: Annotated, hardware: Hardware, settings: Settings
) -> FunctionDerivation | None:
    """Return the derivation that was asked for, if any.

    Raises InputError, before anything is written, for an unknown function.
    """
    if options.explain is None:
        return None
    from tracerisk.pipeline.failure_data.explanation import explain

    return explain(annotated, hardware, settings, options.explain)


def derivation_json(derivation: FunctionDerivation | None) -> dict[str, Any]:
    """Return what `--json` has of it: nothing, or the key `derivation`."""
    if derivation is None:
        return {}
    from tracerisk.adder.figures.derivation_json import derivation_data

    return {"derivation": derivation_data(derivation)}


def print_derivation(
    derivation: FunctionDerivation | None,
    model: HybridModel | None = None,
    assessment: Assessment | None = None,
) -> None:
    """Print it on standard output, where it was asked for; up to the mission of a solved model."""
    if derivation is None:
        return
    from tracerisk.report.explain.function import render_derivation
    from tracerisk.report.explain.mission import render_mission

    text = render_derivation(derivation)
    if model is not None and assessment is not None:
        text += render_mission(model, assessment, derivation.function)
    sys.stdout.buffer.write(escaped(text).encode())
    sys.stdout.flush()
