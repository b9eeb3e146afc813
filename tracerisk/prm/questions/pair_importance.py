"""Second-order importance over the mission: what pairs of parameters do together.

The mixed derivative is that of the first-order importances (`slopes`) along a second parameter, by
the complex step: every number carries its derivative by that parameter as an imaginary part, too
small to touch the real one, and sums, products and quotients carry it on (W. Squire, G. Trapp,
"Using complex variables to estimate derivatives of real functions", SIAM Review 40, 1998).
No difference is taken; the terms of the derivative have either sign all the same, and those of a
latent group nearly cancel: its units mainly change which layer is visited, and much less the
result. So if one of the two parameters belongs to no latent unit, the step is taken along that one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import cast

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.hybrid.adjoint import Adjoint, Slopes, share_of
from tracerisk.prm.hybrid.chain_solver import solve_mission
from tracerisk.prm.hybrid.elements import Parameter
from tracerisk.prm.hybrid.hidden.hidden_chain import HiddenChain
from tracerisk.prm.hybrid.hidden.hidden_states import HiddenStates
from tracerisk.prm.hybrid.hidden.rest_trees import RestTrees
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.importance import held_failure
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.trees.events import BasicEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import slopes, swept

_STEP = 1e-100
"""The imaginary part of the parameter: its square is nothing beside figures above 1e-80."""


@dataclass(frozen=True, slots=True)
class PairImportance:
    """What two parameters do to the mission's failure probability F together.

    Where F is zero, all but `joint_birnbaum` are zero.
    """

    first: str
    """Name of the parameter a."""
    second: str
    """Name of the parameter b."""
    joint_birnbaum: float
    """d2F/(dtheta_a dtheta_b): positive where both must fail, negative where one is enough; for
    latent groups right to rounding of their own Birnbaum importance times visits."""
    joint_criticality: float
    """theta_a theta_b / F times `joint_birnbaum`."""
    fussell_vesely: float
    """(F - F0)/F, with F0 for neither failing, to full precision."""
    interaction: float
    """Part of F common to both: the sum of their own Fussell-Vesely importances less the
    pair's, to rounding of these."""


def pair_importances(
    model: HybridModel, names: Sequence[str] | None = None
) -> tuple[PairImportance, ...]:
    """Return the importance of each pair of the parameters `names`, of all where none are given.

    Pairs that share most of the risk come first.
    Raises ModelError for a name that is not a parameter, for redundant groups too many to be
    solved at once, and as `solve` does.
    """
    parameters = {parameter.name: parameter for parameter in model.parameters}
    for name in names or ():
        if name not in parameters:
            raise ModelError(f"no parameter '{name}'; {one_of(parameters, name)}")
    chosen = list(parameters) if names is None else list(dict.fromkeys(names))
    solved = solve_mission(model)
    if solved.grouped is not None:
        raise ModelError(
            f"{len(solved.grouped.groups)} redundant groups are too many to solve at once, which "
            "importances of pairs need; use importances of single parameters"
        )
    chain, adjoint = solved.chain, Adjoint(solved.chain)
    held = held_failure(chain, solved.flow)

    def fall(*zeros: str) -> float:
        without = HiddenChain(chain.states, dict.fromkeys(zeros, 0.0), base=chain)
        return adjoint.fall(zeros, without, without.flow()) / held if held > 0.0 else 0.0

    alone = {name: fall(name) for name in chosen}
    latent = {name for f in chain.states.functions for name in f.parameters.values()}
    tilted: dict[str, Slopes] = {}
    importances = []
    for first, second in combinations(chosen, 2):
        along, of = (first, second) if second in latent else (second, first)
        if along not in tilted:
            tilted[along] = _slopes_along(chain.states, parameters[along])
        tilts = [slope for _, _, slope in tilted[along].of(parameters[of])]
        joint = math.fsum(tilt.imag for tilt in tilts) / _STEP
        both = fall(first, second)
        scale = parameters[first].theta * parameters[second].theta
        importances.append(
            PairImportance(
                first=first,
                second=second,
                joint_birnbaum=joint,
                joint_criticality=joint * scale / held if held > 0.0 else 0.0,
                fussell_vesely=both,
                interaction=math.fsum((alone[first], alone[second], -both)),
            )
        )
    return tuple(
        sorted(importances, key=lambda pair: (-pair.fussell_vesely, pair.first, pair.second))
    )


def _slopes_along(states: HiddenStates, parameter: Parameter) -> Slopes:
    chain = _TiltedChain(states, parameter)
    return Slopes(chain, chain.flow(), Adjoint(chain))


class _TiltedTrees(RestTrees):
    """The trees of a `_TiltedChain`; values that are real numbers have no derivative."""

    def failure(self, number: int) -> Probability:
        rest, values = self._functions[number].rest, self._values[number]
        here = {name: values[name].real for name in rest.parameters}
        if all(isinstance(values[name], float) for name in here):
            return rest.probability(here)
        if not rest.shared:
            return _sweep(rest, values)[rest.top]
        top, by_event = rest.probability(here), rest.sensitivities(here)
        tilt = math.fsum(
            by_event[event.name] * values[event.parameter].imag for event in rest.events
        )
        return Probability(cast(float, complex(top.p, tilt)), cast(float, complex(top.q, -tilt)))

    def sensitivities(self, number: int) -> Mapping[str, float]:
        rest, values = self._functions[number].rest, self._values[number]
        here = {name: values[name].real for name in rest.parameters}
        if all(isinstance(values[name], float) for name in here):
            return rest.sensitivities(here)
        return _shared_slopes(rest, values) if rest.shared else _slopes(rest, values)


class _TiltedChain(HiddenChain):
    """The chain whose numbers carry their derivative by one parameter as imaginary part."""

    kind_of_trees = _TiltedTrees

    def __init__(self, states: HiddenStates, parameter: Parameter) -> None:
        self._parameter = parameter
        super().__init__(states)

    def _values(self, values: Mapping[str, float]) -> dict[str, float]:
        tilted = dict(values)
        name = self._parameter.name
        if name in tilted:
            step = _STEP * share_of(self._parameter, tilted[name])
            tilted[name] = cast(float, complex(tilted[name], step))
        return tilted


def _sweep(tree: FaultTree, values: Mapping[str, float]) -> dict[str, Probability]:
    nodes = {
        event.name: Probability(values[event.parameter], 1.0 - values[event.parameter])
        for event in tree.events
    }
    nodes |= {house.name: Probability.of(float(house.state)) for house in tree.houses}
    return swept(tree.upwards, nodes, _opposed)


def _opposed(pair: Probability) -> Probability:
    """Return the pair with the derivative of its smaller half, opposite for the other half."""
    p, q = complex(pair.p), complex(pair.q)
    if p.real <= q.real:
        q = complex(q.real, -p.imag)
    else:
        p = complex(p.real, -q.imag)
    return Probability(cast(float, p), cast(float, q))


def _slopes(tree: FaultTree, values: Mapping[str, float]) -> dict[str, float]:
    table = slopes(tree.upwards, tree.top, _sweep(tree, values))
    return {event.name: table[event.name] for event in tree.events}


def _shared_slopes(tree: FaultTree, values: Mapping[str, float]) -> dict[str, float]:
    """Return the sensitivities with their derivative, of a tree whose events are shared.

    The top is linear in each event alone, so that the derivative by one is the difference
    between it happening and not.
    """
    own = replace(tree, events=tuple(BasicEvent(event.name) for event in tree.events))
    here = {event.name: values[event.parameter].real for event in tree.events}
    plain = own.sensitivities(here)
    tilts = dict.fromkeys(plain, 0.0)
    for event in tree.events:
        step = values[event.parameter].imag
        if step != 0.0:
            high = own.sensitivities({**here, event.name: 1.0})
            low = own.sensitivities({**here, event.name: 0.0})
            for name in tilts:
                if name != event.name:
                    tilts[name] += step * (high[name] - low[name])
    return {name: cast(float, complex(plain[name], tilts[name])) for name in plain}
