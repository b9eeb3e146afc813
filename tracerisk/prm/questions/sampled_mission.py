"""The mission's failure probability of a hybrid model, for many draws of its parameters at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Protocol

from tracerisk.prm.hybrid.elements import DONE, FunctionState
from tracerisk.prm.hybrid.fates.ends import FatedChain, WayShares
from tracerisk.prm.hybrid.fates.resolved import (
    chain_model,
    has_fates,
    leads_back,
    undetected_model,
)
from tracerisk.prm.hybrid.groups.group_chain import groups_of, states_with
from tracerisk.prm.hybrid.hidden.hidden_states import (
    Function,
    Hidden,
    HiddenStates,
    hidden_states,
    survives,
    with_more,
)
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.numbers.absorption import absorption
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.probability import Probability, any_of, at_least
from tracerisk.prm.numbers.quantities import check_parameters
from tracerisk.prm.trees.sampled_tree import samples_of, tree_samples

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from tracerisk.prm.numbers.distributions import Samples, Values

_CELLS = 6_000_000
"""How many numbers the chain of one pass may hold; more draws are taken in passes."""

MOST_STATES = 2_000
"""How many states the chain may have, with hidden failures; more failed units count as failure."""

_FAILED = "failed"

_Ways = Sequence[tuple[int | str, float]]
"""What follows a visit that did not fail, functions by number, each with its probability."""

_Rests = Sequence[tuple[Probability, Mapping[str, "Values"], _Ways]]
"""For each function the failure of its tree less the latent units, its parameters, what follows."""


class FailureSampler(Protocol):
    """The mission's failure probability for draws of its parameters."""

    def __call__(self, thetas: Mapping[str, Samples], shares: WayShares | None = None) -> Samples:
        """Return it for each draw, (n,).

        `thetas` gives the drawn parameters their values, (n,) each, and `shares` what follows
        failures; what is not given keeps its value.
        """
        ...


def failure_samples(
    model: HybridModel, thetas: Mapping[str, Samples], *, undetected: bool = False
) -> Samples:
    """Return the mission's failure probability for each draw: (n,); if asked the undetected one.

    `thetas` gives the drawn parameters their values, (n,) each; the others keep theirs.
    Redundant groups too many to be solved at once are solved one by one, and what they add to the
    mission's failure is added up: an upper bound.
    """
    return failure_sampler(model, undetected=undetected)(thetas)


def failure_sampler(model: HybridModel, *, undetected: bool = False) -> FailureSampler:
    """Return `failure_samples` of a model, for block after block of draws.

    What follows failures is only drawn where the states hold all that missions remember.
    """
    if has_fates(model) and (undetected or leads_back(model)):
        chain = FatedChain(model, MOST_STATES)
        if chain.is_whole:
            return _ends_sampler(model, chain, undetected=undetected)
    solved = undetected_model(model) if undetected else chain_model(model)
    states = hidden_states(solved, MOST_STATES)
    groups: list[HiddenStates] = []
    if states.most is not None and len(found := groups_of(states)) > 1:
        groups = [states_with(states, group) for group in found]
        states = states_with(states, ())
    layers = max(len(item.hidden) for item in (states, *groups))
    ways = sum(len(function.steps) + 4 for function in states.functions)
    step = max(64, _CELLS // (ways * layers))
    before = {parameter.name: parameter.theta for parameter in solved.parameters}

    def figure(drawn: Mapping[str, Samples], _: WayShares | None) -> Values:
        rests = _rests(states, before, drawn)
        failed = _failed(states, rests)
        if groups:
            more = [np.maximum(_failed(item, rests) - failed, 0.0) for item in groups]
            failed = np.minimum(failed + sum(more), 1.0)
        return failed

    return _in_passes(figure, step)


def _ends_sampler(model: HybridModel, chain: FatedChain, *, undetected: bool) -> FailureSampler:
    before = {parameter.name: parameter.theta for parameter in model.parameters}

    def figure(drawn: Mapping[str, Samples], shares: WayShares | None) -> Values:
        ends = chain.ends(_DrawnVisits(chain, before, drawn), shares)
        return ends.undetected if undetected else ends.failed

    ways = sum(len(function.steps) + 4 for function in chain.states.functions)
    copies = chain.size // len(chain.functions) * len(chain.states.hidden)
    return _in_passes(figure, max(64, _CELLS // (ways * copies)))


def _in_passes(
    figure: Callable[[Mapping[str, Samples], WayShares | None], Values], step: int
) -> FailureSampler:
    """Return the sampler that draws a figure in passes of so many draws."""

    def samples(thetas: Mapping[str, Samples], shares: WayShares | None = None) -> Samples:
        parts = []
        for start in range(0, len(next(iter(thetas.values()))), step):
            taken = slice(start, start + step)
            drawn = {name: values[taken] for name, values in thetas.items()}
            of_pass = None if shares is None else _taken(shares, taken)
            count = len(next(iter(drawn.values())))
            parts.append(np.broadcast_to(figure(drawn, of_pass), count))
        return np.concatenate(parts)

    return samples


def _taken(shares: WayShares, taken: slice) -> WayShares:
    """Return the shares of some draws."""
    return {
        state: {
            name: {way: p if isinstance(p, float) else p[taken] for way, p in row.items()}
            for name, row in rows.items()
        }
        for state, rows in shares.items()
    }


class _DrawnVisits:
    """The visits of a chain, drawn."""

    def __init__(
        self, chain: FatedChain, before: Mapping[str, float], drawn: Mapping[str, Samples]
    ) -> None:
        self._states = chain.states
        self._number_of = {hidden: number for number, hidden in enumerate(chain.states.hidden)}
        self.values: Sequence[Mapping[str, Values]] = [
            _values(state, before, drawn) for state in chain.functions
        ]

    def rest(self, number: int, values: Mapping[str, Values]) -> Probability:
        return tree_samples(self._states.functions[number].rest, values)

    def latent(self, number: int, layer: int) -> tuple[Probability, Sequence[tuple[int, Values]]]:
        function, hidden = self._states.functions[number], self._states.hidden[layer]
        if not survives(function.parts, hidden):
            return Probability(1.0, 0.0), ()
        units = {c: self.values[number][name] for c, name in function.parameters.items()}
        fails, spread = _visit(self._states, number, hidden, units)
        return any_of(fails), [(self._number_of[after], weight) for after, weight in spread]


def _rests(
    states: HiddenStates,
    before: Mapping[str, float],
    drawn: Mapping[str, Samples],
) -> _Rests:
    rests = []
    for function in states.functions:
        values = _values(function.state, before, drawn)
        # Of the values only those of latent units are asked for again.
        units = {name: values[name] for name in _latent_parameters(function)}
        ways: list[tuple[int | str, float]] = [*function.steps]
        ways += [(DONE, function.done)] if function.done > 0.0 else []
        rests.append((tree_samples(function.rest, values), units, ways))
    return rests


def _latent_parameters(function: Function) -> set[str]:
    """Return the parameters of the units that the tree has beside its rest."""
    inside = {event.name for event in function.rest.events}
    return {e.parameter for e in function.state.tree.events if e.name not in inside}


def _failed(states: HiddenStates, rests: _Rests) -> Values:
    rows: dict[Hashable, Mapping[Hashable, Values]] = {}
    for number in range(len(states.functions)):
        _add_rows(rows, states, number, rests)
    entry = (states.entry, states.hidden[0])
    return absorption(rows, entry).get(_FAILED, 0.0)


def _add_rows(
    rows: dict[Hashable, Mapping[Hashable, Values]],
    states: HiddenStates,
    number: int,
    rests: _Rests,
) -> None:
    """Add the ways out of a function in each hidden state, by (function, hidden state)."""
    function = states.functions[number]
    rest, values, ways = rests[number]
    units = {c: values[name] for c, name in function.parameters.items()}
    held = set(states.hidden)
    for hidden in states.hidden:
        row: dict[Hashable, Values] = {}
        if not survives(function.parts, hidden):
            rows[number, hidden] = {_FAILED: 1.0}
            continue
        fails, spread = _visit(states, number, hidden, units)
        row[_FAILED] = at_least(1, [rest, *fails]).p
        for after, weight in spread:
            through = rest.q * weight
            if after not in held:
                row[_FAILED] = row[_FAILED] + through
                continue
            for target, share in ways:
                key = DONE if target == DONE else (target, after)
                way = through * share
                row[key] = row[key] + way if key in row else way
        rows[number, hidden] = row


def _visit(
    states: HiddenStates, number: int, hidden: Hidden, units: Mapping[int, Values]
) -> tuple[list[Probability], list[tuple[Hidden, Values]]]:
    """Return the failure of each part of latent units, and the hidden states that are left."""
    fails: list[Probability] = []
    spread: list[tuple[Hidden, Values]] = [(hidden, 1.0)]
    for part in states.functions[number].parts:
        if part.spares is not None:
            unit_class, group = part.classes[0], part.spares
            lost = hidden[unit_class]
            survived, gone = group.visits(np.atleast_1d(units[unit_class]), lost)
            fails.append(Probability(gone, sum(survived)))  # type: ignore[arg-type]
            spread = [
                (with_more(state, unit_class, more_failed), share * left)
                for state, share in spread
                for more_failed, left in enumerate(survived)
            ]
            continue
        room = part.threshold - sum(hidden[c] for c in part.classes)
        working = [len(states.classes[c]) - hidden[c] for c in part.classes]
        p: Values = 0.0
        q: Values = 0.0
        grown: list[tuple[Hidden, Values]] = []
        for more in product(*(range(count + 1) for count in working)):
            weight: Values = 1.0
            for c, count, failed in zip(part.classes, working, more, strict=True):
                weight = weight * _binomial(count, failed, units[c])
            if sum(more) >= room:
                p = p + weight
                continue
            q = q + weight
            added = dict(zip(part.classes, more, strict=True))
            grown += [
                (tuple(n + added.get(c, 0) for c, n in enumerate(state)), share * weight)
                for state, share in spread
            ]
        spread = grown
        fails.append(Probability(p, q))  # type: ignore[arg-type]
    return fails, spread


def _binomial(units: int, failed: int, p: Values) -> Values:
    binomial: Values = math.comb(units, failed) * p**failed * (1.0 - p) ** (units - failed)
    return binomial


def _values(
    state: FunctionState, before: Mapping[str, float], drawn: Mapping[str, Samples]
) -> dict[str, Values]:
    values: dict[str, Values] = {}
    for name, value in state.probabilities.items():
        if name not in drawn:
            values[name] = value
        elif before[name] in (0.0, value):
            values[name] = drawn[name]
        else:
            values[name] = drawn[name] * (value / before[name])
    return values


def failure_probabilities(
    model: HybridModel, values: Mapping[str, ArrayLike]
) -> NDArray[np.float64]:
    """Return the mission's failure probability for n samples at once, (n,).

    `values` gives parameters n probabilities theta, (n,), or one for all samples; the others
    keep theirs, and in each state the fixed share of it.
    Raises ModelError when a name is unknown, a value outside [0, 1] or arrays differ in length.
    """
    thetas = {parameter.name: parameter.theta for parameter in model.parameters}
    check_parameters(values, thetas)
    arrays, count = samples_of(values or thetas)
    return failure_samples(
        model, {name: np.broadcast_to(array, (count,)) for name, array in arrays.items()}
    )
