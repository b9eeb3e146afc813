"""From the traces of recorded missions to a field profile, and what sets it apart from the twin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.figures.following import next_counts
from tracerisk.common import trace_json
from tracerisk.common.field.profile import (
    QUANTITIES,
    Estimate,
    FieldProfile,
    FieldStep,
    following,
    ratio,
)
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.text.bounded import MOST_WRITTEN, file_text
from tracerisk.common.trace_log import read_log
from tracerisk.errors import InputError, Location
from tracerisk.trace import Trace, Visit

ROOM = 0.03
"""By what share of its mean a field interval is widened: a twin is no closer than this."""
LEAST_S = 0.05
"""Differences below this are noise [s]."""


@dataclass(frozen=True, slots=True)
class Apart:
    """A difference between the field and the twin."""

    function: str
    """The name of the visited function."""
    element: str
    """The joint, gripper or sensor; empty for the time or number of visits."""
    quantity: str
    """The quantity that differs, such as `moving_s`, `duration_s` or `visits`."""
    twin: float
    """The value on the twin, in the unit of the quantity."""
    field: Estimate
    """The mean in the field with its interval, in the unit of the quantity."""

    def __str__(self) -> str:
        """Return it in words."""
        what = f"{self.element} {self.quantity}" if self.element else self.quantity
        low = self.field.mean if self.field.low is None else self.field.low
        high = self.field.mean if self.field.high is None else self.field.high
        return (
            f"{self.function}: {what} is {self.twin:.4g} on the twin, and {self.field.mean:.4g} "
            f"({low:.4g} to {high:.4g}) in the field"
        )


def read_mission(path: Path) -> Trace:
    """Return the trace of one recorded mission: a trace as JSON, or a log in the published form.

    Raises InputError where the file is neither, or its run failed.
    """
    where = Location(str(path))
    try:
        text = file_text(path, most=MOST_WRITTEN)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read: {error}", where) from error
    if not text.lstrip().startswith("{"):
        return read_log(text, str(path), controller="")
    trace = trace_json.loads(text, str(path))
    if not trace.visits:
        raise InputError("has no visit of a function: it shows no mission", where)
    return trace


def gather_field(traces: Sequence[Trace], names: Sequence[str]) -> FieldProfile:
    """Return what the missions show together; `names` are how messages call each of them.

    Raises InputError where they are of different controllers or robots, or there are none.
    """
    if not traces:
        raise InputError("no recording is given; name traces or logs of missions")
    first = traces[0]
    for trace, name in zip(traces, names, strict=True):
        if (trace.controller, trace.robot) != (first.controller, first.robot):
            raise InputError(
                f"is of {_of(trace)}, but {names[0]} of {_of(first)}; give those of one controller "
                "on one robot",
                Location(name),
            )
    refs = list(dict.fromkeys(function.ref for trace in traces for function in trace.functions))
    model = model_names(refs)
    steps = tuple(_step(ref, model[ref], traces, model) for ref in refs)
    elements = list(dict.fromkeys(item.name for trace in traces for item in trace.elements))
    totals = {
        element: {
            name: sum(_amount(visit, element, name) for trace in traces for visit in trace.visits)
            for name in QUANTITIES
        }
        for element in elements
        if all(visit.exposures.get(element, 0) is not None for t in traces for visit in t.visits)
    }
    return FieldProfile(
        controller=first.controller,
        robot=first.robot,
        missions=len(traces),
        steps=steps,
        totals={name: row for name, row in totals.items() if any(row.values())},
        duration_s=_duration(traces),
    )


def apart_from_twin(found: FieldProfile, twin: Trace) -> list[Apart]:
    """Return what of the twin's run lies outside the intervals of the field.

    Each interval is widened by 3 % of its mean, the accuracy that the twin itself is held to.
    """
    expected = {step.name: step for step in gather_field([twin], [twin.controller]).steps}
    result: list[Apart] = []
    for step in found.steps:
        here = expected.get(step.name)
        if here is None:
            result.append(Apart(step.name, "", "visits", 0.0, step.per_mission))
            continue
        if step.duration_s is not None and here.duration_s is not None:
            simulated = here.duration_s.mean
            if step.duration_s.excludes(simulated, within=ROOM) and _differ(
                simulated, step.duration_s
            ):
                result.append(Apart(step.name, "", "duration_s", simulated, step.duration_s))
        for element, row in step.uses.items():
            for name, estimate in row.items():
                simulated = here.uses[element][name].mean if element in here.uses else 0.0
                if estimate.excludes(simulated, within=ROOM) and _differ(simulated, estimate):
                    result.append(Apart(step.name, element, name, simulated, estimate))
    known = {step.name for step in found.steps}
    result += [
        Apart(name, "", "visits", step.per_mission.mean, Estimate(0.0, 0.0, 0.0))
        for name, step in expected.items()
        if name not in known
    ]
    return result


def _differ(simulated: float, estimate: Estimate) -> bool:
    return abs(simulated - estimate.mean) >= LEAST_S


def _of(trace: Trace) -> str:
    return f"{trace.controller or 'a log'} on {trace.robot}" if trace.robot else "a log"


def _step(
    ref: FunctionRef, name: str, traces: Sequence[Trace], model: dict[FunctionRef, str]
) -> FieldStep:
    visits = [[visit for visit in trace.visits if visit.function == ref] for trace in traces]
    numbers = [float(len(visit)) for visit in visits]
    counts: dict[str, int] = {}
    for trace in traces:
        own = {function.ref: function for function in trace.functions}
        if ref in own:
            short = model_names([function.ref for function in trace.functions])
            full = {short[function_ref]: model[function_ref] for function_ref in own}
            for target, count in next_counts(trace)[ref].items():
                key = full.get(target, target)
                counts[key] = counts.get(key, 0) + count
    times = [[visit.duration_s for visit in row] for row in visits]
    known = all(value is not None for row in times for value in row)
    used = dict.fromkeys(element for row in visits for visit in row for element in visit.exposures)
    uses = {
        element: {
            name_of: ratio(
                [sum(_amount(visit, element, name_of) for visit in row) for row in visits], numbers
            )
            for name_of in QUANTITIES
        }
        for element in used
        if all(visit.exposures.get(element, 0) is not None for row in visits for visit in row)
    }
    return FieldStep(
        name=name,
        visits=int(sum(numbers)),
        per_mission=ratio(numbers, [1.0] * len(numbers)),
        duration_s=ratio([sum(value or 0.0 for value in row) for row in times], numbers)
        if known
        else None,
        uses=uses,
        following=following(counts) if counts else {},
    )


def _amount(visit: Visit, element: str, name: str) -> float:
    exposure = visit.exposures.get(element)
    return 0.0 if exposure is None else float(getattr(exposure, name))


def _duration(traces: Sequence[Trace]) -> float | None:
    times = [visit.duration_s for trace in traces for visit in trace.visits]
    return None if None in times else sum(time for time in times if time is not None)
