"""The chain of a model that says what follows its failures: each end of a mission is a state.

A visit that does not fail unnoticed stops late, stops safely, leads back, or goes on; where a
failure shows in a later function, it goes on in states that remember it. There, any other failure
and the end of the mission leave it unnoticed. Of several failures in one visit the worst decides.
Point values and draws take the same rows. All of it is our own derivation; see docs/theory.md.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, Protocol

from tracerisk.prm.hybrid.elements import DONE, FateKind, FunctionState, NextStep
from tracerisk.prm.hybrid.hidden.hidden_chain import HiddenChain
from tracerisk.prm.hybrid.hidden.hidden_states import MOST_STATES, hidden_states
from tracerisk.prm.hybrid.hidden.rest_trees import tree_probability
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.numbers.absorption import absorption
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.probability import Probability

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Values

UNAWARE, STOPPED_LATE, STOPPED_SAFELY = "unaware", "stopped_late", "stopped_safely"
"""The ends of a mission that fails."""

_WORST_FIRST: tuple[FateKind, ...] = ("unaware", "stopped_late", "stopped_safely", "back")
_TINY = 1e-300
"""Added to what is divided by where that may be 0."""
_BELOW_ONE = 1.0 - 2.0**-53


class Way(NamedTuple):
    """What follows a failure."""

    kind: FateKind
    """What becomes of the mission."""
    target: str
    """For `back` the function that follows; else empty."""
    shows_in: str
    """The later function in which the failure shows; empty where it shows at once."""


UNNOTICED = Way("unaware", "", "")
"""What nobody notices; what no fate is known of too."""

WayShares = Mapping[str, Mapping[str, Mapping[Way, "Values"]]]
"""The share of each way in the failures of a parameter, by state and parameter; they sum to 1."""


class At(NamedTuple):
    """A state of the chain in which the mission goes on."""

    function: int
    """Number of the function that is visited next."""
    layer: int
    """Number of the hidden state: which latent units have failed."""
    remembered: Way | None
    """What becomes of a failure once it shows; `None` for no failure to remember."""


Rows = Mapping[Hashable, Mapping[Hashable, "Values"]]
"""The ways out of each state of the chain, an `At` each; ends have none."""


class Visits(Protocol):
    """How visits of functions fail, for point values or draws."""

    values: Sequence[Mapping[str, Values]]
    """Probability that a unit fails in one visit, by function and parameter."""

    def rest(self, number: int, values: Mapping[str, Values]) -> Probability:
        """Return how a function's tree without its latent units fails with such values."""
        ...

    def latent(self, number: int, layer: int) -> tuple[Probability, Sequence[tuple[int, Values]]]:
        """Return how the latent units fail a visit, and the layers to which they do not."""
        ...


@dataclass(frozen=True, slots=True)
class MissionEnds:
    """The probability of each end of a mission."""

    unaware: Values
    """The mission fails, and nobody notices; also where a failure shows only after the end."""
    stopped_late: Values
    """It stops, but harm came before."""
    stopped_safely: Values
    """It stops before any harm."""
    done: Values
    """It is carried out."""

    @property
    def undetected(self) -> Values:
        """The probability that nobody notices, or that harm comes before the stop."""
        return self.unaware + self.stopped_late

    @property
    def failed(self) -> Values:
        """The probability that the mission fails."""
        return self.unaware + self.stopped_late + self.stopped_safely


class FatedChain:
    """The chain of a model that says what follows its failures, with its hidden failures."""

    def __init__(self, model: HybridModel, limit: int = MOST_STATES) -> None:
        """Prepare the chain; raise ModelError where a tree cannot carry its latent units."""
        self.model = model
        self.states = hidden_states(_with_every_way(model), limit)
        of_name = {state.name: state for state in model.states}
        self.functions = [of_name[function.state.name] for function in self.states.functions]
        self.entry = At(self.states.entry, 0, None)
        self.shares = way_shares(model)
        self._number_of = {state.name: number for number, state in enumerate(self.functions)}
        self._rank = {state.name: rank for rank, state in enumerate(model.states)}
        # In a mission without memory of a failure, and with each that it may remember.
        kept = {way for rows in self.shares.values() for row in rows.values() for way in row}
        self.size = len(self.functions) * (1 + sum(bool(way.shows_in) for way in kept))
        self.is_whole = self.states.most is None and self.size * len(self.states.hidden) <= limit

    @cached_property
    def point(self) -> HiddenChain:
        """The chain of the functions as if every failure ended the mission."""
        return HiddenChain(self.states)

    def ends(self, visits: Visits | None = None, shares: WayShares | None = None) -> MissionEnds:
        """Return how missions end; with point values unless others are given.

        Raises ModelError when a tree cannot be solved.
        """
        reached = absorption(self.rows(visits, shares), self.entry)
        names = (UNAWARE, STOPPED_LATE, STOPPED_SAFELY, DONE)
        return MissionEnds(*(reached.get(name, 0.0) for name in names))

    def rows(self, visits: Visits | None = None, shares: WayShares | None = None) -> Rows:
        """Return the chain, from its entry on; every state that it names is a row or an end."""
        known = _PointVisits(self.point) if visits is None else visits
        taken = self.shares if shares is None else shares
        fated = [
            self._fated(number, known, taken.get(state.name, {}))
            for number, state in enumerate(self.functions)
        ]
        rows: dict[Hashable, dict[Hashable, Values]] = {}
        waiting = [self.entry]
        while waiting:
            now = waiting.pop()
            if now in rows:
                continue
            rows[now] = row = self._row(now, known, fated[now.function])
            waiting += [key for key in row if isinstance(key, At)]
        return rows

    def _fated(
        self, number: int, visits: Visits, shares: Mapping[str, Mapping[Way, Values]]
    ) -> _FatedVisit:
        state = self.functions[number]
        values = visits.values[number]
        order = sorted({way for row in shares.values() for way in row}, key=self._order)
        worst = {name: row.get(UNNOTICED, 0.0) for name, row in shares.items()}
        scaled = {**values, **{name: values[name] * share for name, share in worst.items()}}
        ways, left = ways_on(
            state, [way for way in order if way != UNNOTICED], shares, values, worst
        )
        whole = visits.rest(number, values)
        return _FatedVisit(visits.rest(number, scaled) if shares else whole, ways, left, whole)

    def _order(self, way: Way) -> tuple[int, bool, int, int]:
        """Return how bad a way is, the worst first: of stops those at once, of ways back not."""
        is_back = way.kind == "back"
        return (
            _WORST_FIRST.index(way.kind),
            bool(way.shows_in) != is_back,
            self._rank.get(way.target, -1),
            self._rank.get(way.shows_in, -1),
        )

    def _row(self, now: At, visits: Visits, fated: _FatedVisit) -> dict[Hashable, Values]:
        row: dict[Hashable, Values] = {}

        def add(key: Hashable, p: Values) -> None:
            if not isinstance(p, float) or p > 0.0:
                row[key] = row[key] + p if key in row else p

        latent, spread = visits.latent(now.function, now.layer)
        rest = fated.unaware if now.remembered is None else fated.whole
        add(UNAWARE, rest.p + rest.q * latent.p)
        for layer, weight in spread:
            through = rest.q * weight
            if now.remembered is not None:
                for key, onward in self._onward(now.function, layer, now.remembered):
                    add(key, through * onward)
                continue
            for way, share in fated.ways.items():
                if not way.shows_in:
                    add(self._shown(way, layer), through * share)
                    continue
                for key, onward in self._onward(now.function, layer, way):
                    add(key, through * share * onward)
            for key, onward in self._onward(now.function, layer, None):
                add(key, through * fated.left * onward)
        return row

    def _onward(
        self, number: int, layer: int, remembered: Way | None
    ) -> Iterator[tuple[Hashable, float]]:
        """Yield what follows a visit that goes on, each with its share."""
        for step in self.functions[number].next:
            share = float(step.weight)
            if share == 0.0:
                continue
            if step.target == DONE:
                yield (DONE if remembered is None else UNAWARE), share
            elif remembered is not None and step.target == remembered.shows_in:
                yield self._shown(remembered, layer), share
            else:
                yield At(self._number_of[step.target], layer, remembered), share

    def _shown(self, way: Way, layer: int) -> Hashable:
        """Return where the mission is once a failure shows."""
        return At(self._number_of[way.target], layer, None) if way.target else way.kind


class _FatedVisit(NamedTuple):
    """How a visit of a function ends, latent units apart."""

    unaware: Probability
    """The visit fails, and nobody will notice."""
    ways: Mapping[Way, Values]
    """What else follows failures, given that it does not."""
    left: Values
    """Probability that nothing failed, given that it does not."""
    whole: Probability
    """Something fails."""


class _PointVisits:
    """The visits of a chain with its point values."""

    def __init__(self, chain: HiddenChain) -> None:
        self._chain = chain
        self.values: Sequence[Mapping[str, Values]] = chain.values

    def rest(self, number: int, values: Mapping[str, Values]) -> Probability:
        function = self._chain.states.functions[number]
        return tree_probability(function.state.name, function.rest, values)  # type: ignore[arg-type]

    def latent(self, number: int, layer: int) -> tuple[Probability, Sequence[tuple[int, Values]]]:
        chain = self._chain
        if not chain.states.functions[number].parts:
            return Probability(0.0, 1.0), ((layer, 1.0),)
        return chain.latent_failure(number, layer), chain.spread(number, layer)


def way_shares(model: HybridModel) -> dict[str, dict[str, dict[Way, float]]]:
    """Return the ways that follow failures, of the states and parameters of which any are known."""
    shares: dict[str, dict[str, dict[Way, float]]] = {}
    for state in model.states:
        for parameter, fates in state.fates.items():
            exact = {UNNOTICED: 1 - sum((fate.share for fate in fates), Fraction(0))}
            for fate in fates:
                is_unaware = fate.kind == "unaware"
                way = UNNOTICED if is_unaware else Way(fate.kind, fate.target, fate.shows_in)
                exact[way] = exact.get(way, Fraction(0)) + fate.share
            shares.setdefault(state.name, {})[parameter] = {
                way: float(share) for way, share in exact.items() if share > 0
            }
    return shares


def ways_on(
    state: FunctionState,
    order: Sequence[Way],
    shares: Mapping[str, Mapping[Way, Values]],
    values: Mapping[str, Values],
    worst: Mapping[str, Values],
) -> tuple[dict[Way, Values], Values]:
    """Return what follows failures in a visit, the worst first, and that nothing failed.

    Each with its probability, given that nothing worse happened than `order` names; `worst` is
    the share of that in the failures of each parameter.
    """
    units: dict[str, int] = {}
    for event in state.tree.events:
        units[event.parameter] = units.get(event.parameter, 0) + 1
    before = dict(worst)
    left: Values = 1.0
    ways: dict[Way, Values] = {}
    for way in order:
        log: Values = 0.0
        for name, row in shares.items():
            if way in row:
                p, share = values[name], row[way]
                log = log + units[name] * _log_complement(
                    p * share / (1.0 - p * before[name] + _TINY)
                )
                before[name] = before[name] + share
        happens, not_so = _of_log(log)
        ways[way] = left * happens
        left = left * not_so
    return ways, left


def _log_complement(p: Values) -> Values:
    """Return ln(1-p), for 1 that of the double below it."""
    if isinstance(p, float):
        return math.log1p(-min(p, _BELOW_ONE))
    return np.log1p(-np.minimum(p, _BELOW_ONE))


def _of_log(log: Values) -> tuple[Values, Values]:
    """Return a probability and its complement, of which the logarithm is given."""
    if isinstance(log, float):
        return 0.0 - math.expm1(log), math.exp(log)
    return 0.0 - np.expm1(log), np.exp(log)


def _with_every_way(model: HybridModel) -> HybridModel:
    """Return the model in which each function also leads where its failures lead back.

    The shares of what follows are not those of missions: only what is reached counts.
    """
    states = []
    for state in model.states:
        targets = [step.target for step in state.next if step.weight > 0]
        targets += [fate.target for fates in state.fates.values() for fate in fates if fate.target]
        distinct = list(dict.fromkeys(targets))
        share = Fraction(1, len(distinct))
        steps = tuple(NextStep(target, share) for target in distinct)
        states.append(replace(state, next=steps, fates={}))
    return replace(model, states=tuple(states))
