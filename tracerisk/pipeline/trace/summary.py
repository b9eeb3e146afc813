"""What the lock keeps of a run for users to read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.figures.instances import ComponentInstances
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.outcome.changes import outcome_changes
from tracerisk.common.outcome.kept import OUTCOME, kept_outcome, kept_tolerances, outcome_summary
from tracerisk.common.outcome.tolerances import TOLERANCES, Tolerances
from tracerisk.common.trace_json import trace_digest
from tracerisk.common.worlds.world_run import WorldRun, joined_worlds, worlds_summary
from tracerisk.pipeline.trace.kept_verdict import verdict_summary
from tracerisk.pipeline.trace.last_run import last_run_summary, repeats_summary
from tracerisk.trace import Trace

DIGEST = "digest"
"""The key of the digest of the whole trace."""


def trace_summary(
    trace: Trace,
    instances: Sequence[ComponentInstances] = (),
    *,
    kept: Mapping[str, Any] | None = None,
    noise: float = 0.0,
    tolerances: Tolerances = TOLERANCES,
    worlds: Sequence[WorldRun] = (),
) -> dict[str, Any]:
    """Return what the lock keeps of a trace: by function the exposures of each element [s].

    Beside these stand, by component, the failure probabilities of its instances in one visit,
    with 4 significant digits. The verdict of the run is kept with its reasons, its lines
    as they are given. Where the lock has the summary `kept` of the very same run, a number that
    differs from it by no more than `noise`, relatively, stays as it is there; where all do, so
    does the digest of the trace, and two processors write the same. Motions that never ran and
    unexpected contacts are kept where there are any.
    `worlds` are runs of the same inputs in worlds that the trace does not have.
    """
    functions: dict[str, Any] = {}
    names = model_names([function.ref for function in trace.functions])
    for function in trace.functions:
        visits = [visit for visit in trace.visits if visit.function == function.ref]
        elements: dict[str, Any] = {}
        for element in trace.elements:
            exposures = [e for v in visits if (e := v.exposures.get(element.name)) is not None]
            if element.kind == "sensor":
                # One that is not read is in use with its joint, which stands here.
                read_s = _rounded(math.fsum(e.reading_s for e in exposures))
                if read_s:
                    elements[element.name] = {"reading_s": read_s}
            elif any(exposure.active_s for exposure in exposures):
                elements[element.name] = {
                    "moving_s": _rounded(math.fsum(e.moving_s for e in exposures)),
                    "holding_s": _rounded(math.fsum(e.holding_s for e in exposures)),
                    "grasping_s": _rounded(math.fsum(e.grasping_s for e in exposures)),
                }
        known = [visit.duration_s for visit in visits if visit.duration_s is not None]
        name = names[function.ref]
        functions[name] = {
            "visits": len(visits),
            "duration_s": _rounded(math.fsum(known)),
            "elements": elements,
            "instances": _instances(function.ref, instances),
            **repeats_summary(trace, visits),
        }
    summary = {
        "robot": trace.robot,
        "scene": trace.scene,
        "end": trace.end.cause,
        DIGEST: trace_digest(trace),
        "functions": functions,
        **verdict_summary(trace.verdict),
        **last_run_summary(trace),
        **_outcome(trace, kept or {}, tolerances),
        **worlds_summary(joined_worlds(worlds, trace.worlds)),
    }
    if kept is None or not noise:
        return summary
    steady: dict[str, Any] = _steady(kept, summary, noise)
    as_kept = {**steady, DIGEST: kept.get(DIGEST, summary[DIGEST])}
    return as_kept if as_kept == {**as_kept, **kept} else steady


def is_run_of(kept: Mapping[str, Any], trace: Trace) -> bool:
    """Return whether a trace is, to the digit, the one of which a lock keeps this summary."""
    return bool(kept.get(DIGEST) == trace_digest(trace))


def _steady(before: Any, now: Any, noise: float) -> Any:
    """Return plain data with each number as it was before, where the two differ by mere noise."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        return {key: _steady(before.get(key), value, noise) for key, value in now.items()}
    if isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        return [_steady(old, new, noise) for old, new in zip(before, now, strict=True)]
    if isinstance(before, float) and isinstance(now, float):
        return before if abs(now - before) <= noise * abs(before) else now
    return now


def _outcome(trace: Trace, kept: Mapping[str, Any], tolerances: Tolerances) -> dict[str, Any]:
    """Return the outcome as the lock keeps it: what it has, where that says the same."""
    outcome = outcome_summary(trace.outcome, tolerances)
    before, now = kept_outcome(kept), kept_outcome(outcome)
    if (
        before is not None
        and now is not None
        and kept_tolerances(kept) == tolerances
        and not outcome_changes(before, now, tolerances)
        # A lock of an earlier version does not know where the arms began.
        and [rest.from_m is None for rest in before.rests]
        == [rest.from_m is None for rest in now.rests]
    ):
        return {OUTCOME: kept[OUTCOME]}
    return outcome


def _instances(
    function: FunctionRef, instances: Sequence[ComponentInstances]
) -> dict[str, dict[str, float]]:
    values_by_component = {}
    for instance in instances:
        values = instance.in_function(function)
        if values:
            values_by_component[instance.component.name] = {
                element: float(f"{value:.4g}") for element, value in values.items()
            }
    return values_by_component


def _rounded(seconds: float) -> float:
    return round(seconds, 3)
