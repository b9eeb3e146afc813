"""Where the figures of one function come from: the run, the description and the block joined."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tracerisk.adder.figures.derive import derive_function, function_named
from tracerisk.adder.sources.read import read_blocks
from tracerisk.pipeline.freshness.used_evidence import used_evidence

if TYPE_CHECKING:
    from tracerisk.adder.figures.derivation import FunctionDerivation
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.config import Settings
    from tracerisk.pipeline.annotate import Annotated


def explain(
    annotated: Annotated, hardware: Hardware, settings: Settings, function: str
) -> FunctionDerivation:
    """Return where the figures in the block of a function come from.

    `function` is its name in the model; the block is that of the annotated source.
    Raises InputError, with the names that there are, for an unknown function.
    """
    ref = function_named(annotated.trace, function)
    name = str(annotated.controller.path_of(ref.file))
    blocks = {
        placed.function: placed.block for placed in read_blocks(annotated.sources[ref.file], name)
    }
    return derive_function(
        annotated.trace,
        hardware,
        ref,
        active=settings.active,
        block=blocks.get(ref.name),
        evidence=used_evidence(annotated.controller, settings, annotated.fingerprint),
    )
