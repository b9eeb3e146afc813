"""What the lock keeps of a run for a person to read."""

from __future__ import annotations

from typing import Any

from tracerisk.adder.model_names import model_names
from tracerisk.trace import Trace


def trace_summary(trace: Trace) -> dict[str, Any]:
    """Return what the lock keeps of a trace: the exposures of each function's elements [s]."""
    functions: dict[str, Any] = {}
    names = model_names([function.ref for function in trace.functions])
    for function in trace.functions:
        visits = [visit for visit in trace.visits if visit.function == function.ref]
        elements: dict[str, Any] = {}
        for element in trace.elements:
            found = [e for v in visits if (e := v.exposures.get(element.name)) is not None]
            if any(exposure.active_s for exposure in found):
                elements[element.name] = {
                    "moving_s": _rounded(sum(e.moving_s for e in found)),
                    "holding_s": _rounded(sum(e.holding_s for e in found)),
                    "grasping_s": _rounded(sum(e.grasping_s for e in found)),
                }
        known = [visit.duration_s for visit in visits if visit.duration_s is not None]
        functions[names[function.ref]] = {
            "visits": len(visits),
            "duration_s": _rounded(sum(known)),
            "elements": elements,
        }
    return {
        "robot": trace.robot,
        "scene": trace.scene,
        "end": trace.end.cause,
        "functions": functions,
    }


def _rounded(seconds: float) -> float:
    return round(seconds, 3)
