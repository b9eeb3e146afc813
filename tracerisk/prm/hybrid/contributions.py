"""How much a visit's failure probability falls without a component, over a mission's visits."""

from __future__ import annotations

import math

from tracerisk.prm.hybrid.chain_solver import SolvedMission
from tracerisk.prm.hybrid.hidden.hidden_chain import Flow, HiddenChain
from tracerisk.prm.hybrid.hidden.hidden_states import Part
from tracerisk.prm.hybrid.hidden.rest_trees import tree_probability
from tracerisk.prm.numbers.binomial import failure_counts
from tracerisk.prm.numbers.probability import Probability


def mean_drops(solved: SolvedMission, number: int) -> dict[str, float]:
    """Return for each parameter of a function the mean drop over its visits.

    A component that never fails has no hidden failures either.
    Groups that are solved by themselves each have their drop where no other one fails.
    """
    values = _mean_drops(solved.chain, solved.flow, number)
    grouped = solved.grouped
    if grouped is not None:
        parts: dict[str, list[float]] = {}
        for group in grouped.groups_in[number]:
            chain = grouped.own[group]
            drops = _mean_drops(chain, grouped.own_flows[group], number)
            for name in set(chain.states.functions[number].parameters.values()):
                # The drop of the rest of the tree is counted only once.
                before = parts.setdefault(name, [])
                before.append(max(0.0, drops[name] - values[name]) if before else drops[name])
        values |= {name: math.fsum(part) for name, part in parts.items()}
    return values


def _mean_drops(chain: HiddenChain, flow: Flow, number: int) -> dict[str, float]:
    function = chain.states.functions[number]
    values = chain.values[number]
    if not function.parts:
        return {name: chain.trees.drop(number, name) for name in values}
    met = [(layer, row[number]) for layer, row in enumerate(flow.visits[:-1]) if row[number] > 0.0]
    total = math.fsum(count for _, count in met)
    mean_drops = {}
    # What the latent units leave of the drop of any other component.
    left = math.fsum(count / total * chain.latent_failure(number, layer).q for layer, count in met)
    for name in values:
        if name not in function.parameters.values():
            mean_drops[name] = chain.trees.drop(number, name) * left
            continue
        rest = _rest(chain, number, name)
        mean_drops[name] = math.fsum(
            count / total * _drop(chain, number, layer, name, rest) for layer, count in met
        )
    return mean_drops


_Item = tuple[Probability, Probability, float]
"""A part's failure as it is and without the component, and what it falls by."""


def _rest(chain: HiddenChain, number: int, name: str) -> _Item:
    function, values = chain.states.functions[number], chain.values[number]
    here = chain.rest[number]
    if name not in function.rest.parameters:
        return here, here, 0.0
    without = tree_probability(function.state.name, function.rest, {**values, name: 0.0})
    return here, without, chain.trees.drop(number, name)


def _drop(chain: HiddenChain, number: int, layer: int, name: str, rest: _Item) -> float:
    """Return the drop in one hidden state; the parts fail the visit independently.

    The component is removed from one part after the other: the parts before are already without it,
    those after still have it.
    """
    function = chain.states.functions[number]
    items = [rest, *(_part(chain, number, part, layer, name) for part in function.parts)]
    drops = []
    for index, (_, _, drop) in enumerate(items):
        if drop > 0.0:
            before = math.prod(without.q for _, without, _ in items[:index])
            after = math.prod(here.q for here, _, _ in items[index + 1 :])
            drops.append(before * drop * after)
    return math.fsum(drops)


def _part(chain: HiddenChain, number: int, part: Part, layer: int, name: str) -> _Item:
    here = chain.part_failure(number, part, layer)
    function = chain.states.functions[number]
    if all(function.parameters[c] != name for c in part.classes):
        return here, here, 0.0
    if part.spares is not None:
        # Its units are all of the component; none of them fails, nor has failed.
        return here, Probability(0.0, 1.0), here.p
    own, others = [1.0], [1.0]
    for unit_class in part.classes:
        counts = _failed(chain, number, unit_class, layer)
        if function.parameters[unit_class] == name:
            own = _convolved(own, counts)
        else:
            others = _convolved(others, counts)
    least = part.threshold
    drop = math.fsum(
        p * math.fsum(own[max(least - failed, 0) :]) for failed, p in enumerate(others[:least])
    )
    without = Probability(math.fsum(others[least:]), math.fsum(others[:least]))
    return here, without, drop


def _failed(chain: HiddenChain, number: int, unit_class: int, layer: int) -> list[float]:
    """Return the distribution of the failed units of a class at the end of a visit."""
    before = chain.states.hidden[layer][unit_class]
    working = chain.states.working(layer, unit_class)
    p = chain.units[number][unit_class]
    return [0.0] * before + list(failure_counts(working, p, working))


def _convolved(one: list[float], other: list[float]) -> list[float]:
    grown = [0.0] * (len(one) + len(other) - 1)
    for first, p in enumerate(one):
        for second, q in enumerate(other):
            grown[first + second] += p * q
    return grown
