"""Static and dynamic fault trees to Galileo text."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.dynamic import DynamicGate, DynamicKind, DynamicTree
from tracerisk.prm.trees.events import FailureModel
from tracerisk.prm.trees.failure_models import (
    GLM,
    Constant,
    Erlang,
    Exponential,
    Lognormal,
    PerDemand,
    Weibull,
)
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

_KINDS = {
    GateKind.AND: "and",
    GateKind.INHIBIT: "and",
    GateKind.OR: "or",
    GateKind.TRANSFER: "or",
}
_UNSAFE = re.compile(r"[^A-Za-z0-9_-]+")


def dumps(
    tree: FaultTree | DynamicTree,
    values: Mapping[str, float] | None = None,
    mission_time_h: float | None = None,
) -> str:
    """Return a tree as Galileo text, the same bytes each time; times are hours, rates per hour.

    `values` gives the parameters of a static tree their probabilities, as for
    `FaultTree.probability`; events without one there are written by their model. A model that
    Galileo has no word for is written as its probability in a mission of `mission_time_h`.
    Names keep letters, digits, `_` and `-`, which every tool can read; where one changes, a comment
    says what it was.
    Raises ModelError for what Galileo cannot hold: gates that are not coherent, switches of spares
    that fail, and models without a word for them where no mission time is given.
    """
    names = _names(tree)
    renamed = [(new, old) for old, new in names.items() if new != old]
    lines = [f"// {new} is {old}" for new, old in renamed]
    lines.append(f'toplevel "{names[tree.top]}";')
    lines += [
        f'"{names[gate.name]}" {kind}{_listed(names, gate.inputs)};' for gate, kind in _gates(tree)
    ]
    if isinstance(tree, DynamicTree):
        for tie in tree.dependencies:
            kind = "fdep" if tie.probability == 1.0 else f"pdep={tie.probability!r}"
            lines.append(f'"{names[tie.name]}" {kind}{_listed(names, tie.inputs)};')
        lines += [
            f'"{names[tie.name]}" {tie.kind.value}{_listed(names, tie.inputs)};'
            for tie in tree.restrictions
        ]
    for event, law, dormancy in _laws(tree, values or {}, mission_time_h):
        lines.append(f'"{names[event]}" {law} dorm={dormancy!r};')
    return "\n".join(lines) + "\n"


def _listed(names: Mapping[str, str], inputs: Iterable[str]) -> str:
    return "".join(f' "{names[name]}"' for name in inputs)


def _names(tree: FaultTree | DynamicTree) -> dict[str, str]:
    """Return for each name the one to write, all of them different."""
    result = [element.name for element in (*tree.gates, *tree.events)]
    if isinstance(tree, DynamicTree):
        result += [tie.name for tie in tree.ties]
    else:
        result += [house.name for house in tree.houses]
    taken = {name for name in result if not _UNSAFE.search(name)}
    names = {}
    for name in result:
        new = name
        if name not in taken:
            stem = _UNSAFE.sub("_", name).strip("_") or "element"
            new, number = stem, 2
            while new in taken:
                new, number = f"{stem}_{number}", number + 1
            taken.add(new)
        names[name] = new
    return names


def _gates(tree: FaultTree | DynamicTree) -> Iterator[tuple[Gate | DynamicGate, str]]:
    """Yield the gates, from the top downwards, with the words for their kinds."""
    for gate in reversed(tree.upwards):
        if isinstance(gate, DynamicGate):
            if gate.switch:
                raise ModelError(
                    f"gate '{gate.name}': Galileo has no spares whose switch fails; "
                    "model the switch as a separate event"
                )
            kind = "wsp" if gate.kind is DynamicKind.SPARE else gate.kind.value
            yield gate, kind if gate.inclusive else f"{kind}-excl"
        elif gate.kind is GateKind.ATLEAST:
            yield gate, f"{gate.k}of{len(gate.inputs)}"
        elif gate.kind not in _KINDS:
            allowed = one_of([*(kind.value for kind in _KINDS), "atleast", "pand", "por", "spare"])
            raise ModelError(f"gate '{gate.name}': Galileo has no {gate.kind.value}; {allowed}")
        elif gate.inputs:
            yield gate, _KINDS[gate.kind]


def _laws(
    tree: FaultTree | DynamicTree, values: Mapping[str, float], mission_time_h: float | None
) -> Iterator[tuple[str, str, float]]:
    """Yield each event with its failure law and dormancy."""
    if isinstance(tree, DynamicTree):
        for event in tree.events:
            yield event.name, _law(event.name, event.model, mission_time_h), event.dormancy
        return
    for basic in tree.events:
        if basic.parameter in values:
            yield basic.name, _law(basic.name, Constant(values[basic.parameter]), None), 1.0
        elif basic.model is not None:
            yield basic.name, _law(basic.name, basic.model, mission_time_h), 1.0
        else:
            raise ModelError(
                f"event '{basic.name}': parameter '{basic.parameter}' has neither a value nor a "
                f"model; {one_of(values, basic.parameter)}"
            )
    for house in tree.houses:
        yield house.name, f"prob={float(house.state)!r}", 1.0
    for gate in tree.gates:
        if not gate.inputs:
            # What never happens: Galileo has no gates without inputs.
            yield gate.name, "prob=0.0", 1.0


def _law(name: str, model: FailureModel, mission_time_h: float | None) -> str:
    if isinstance(model, Constant | PerDemand):
        return f"prob={model.probability(0.0).p!r}"
    if isinstance(model, Exponential):
        return f"lambda={float(model.rate)!r}"
    if isinstance(model, GLM) and model.failure_on_demand == 0.0:
        return f"lambda={float(model.failure_rate)!r} repair={float(model.repair_rate)!r}"
    if isinstance(model, Erlang):
        return f"lambda={float(model.rate)!r} phases={model.phases}"
    if isinstance(model, Weibull) and model.location_h == model.age_h == 0.0:
        return f"rate={_rate_of(model.scale_h)!r} shape={float(model.shape)!r}"
    if isinstance(model, Lognormal):
        return f"mean={float(model.mean)!r} stddev={float(model.deviation)!r}"
    if mission_time_h is None:
        raise ModelError(
            f"event '{name}': Galileo cannot express {type(model).__name__}; give a mission time "
            "to write its probability"
        )
    return f"prob={model.probability(mission_time_h).p!r}"


def _rate_of(scale: float) -> float:
    """Return the rate that is read back as this scale, the shortest to write of those there are."""
    rate = 1.0 / scale
    near = (math.nextafter(rate, 0.0), rate, math.nextafter(rate, math.inf))
    exact = [one for one in near if 1.0 / one == scale]
    return min(exact or [rate], key=lambda one: len(repr(one)))
