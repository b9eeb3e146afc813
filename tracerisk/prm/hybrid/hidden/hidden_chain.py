"""The chain of a model with hidden failures, for one assignment of its parameters.

A visit of a function in a hidden state fails, or goes on with the same units failed or with more.
So the chain falls into layers, one for each hidden state, which are left for others but never
come back: each is eliminated by itself (`elimination`), and what leaves one enters later ones.
Every number is a sum of products of probabilities; nothing is subtracted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from tracerisk.prm.hybrid.hidden.hidden_states import HiddenStates, Part
from tracerisk.prm.hybrid.hidden.rest_trees import RestTrees
from tracerisk.prm.numbers.binomial import failure_counts, group_failures
from tracerisk.prm.numbers.elimination import Elimination
from tracerisk.prm.numbers.probability import Probability, any_of, pair_of, total
from tracerisk.prm.trees.spares import Outcome

Spread = tuple[tuple[int, float], ...]
"""Where a visit leads: layers, each with its probability."""


class Flow(NamedTuple):
    """What flows through the chain from a start: by layer and function, by layer, by function.

    The last layer stands for more failed units than `hidden` holds.
    """

    visits: tuple[tuple[float, ...], ...]
    """Expected visits of each function in each layer, (n_layers + 1, n_functions)."""
    failures: tuple[tuple[float, ...], ...]
    """Expected failures of each function in each layer, (n_layers + 1, n_functions)."""
    done: tuple[float, ...]
    """Probability that the mission ends well in each layer, (n_layers + 1,)."""
    back: tuple[float, ...]
    """Probability that a round ends in each layer, (n_layers + 1,); 0 without a round."""
    beyond: tuple[float, ...]
    """Probability that each function is the first visited in the last layer, (n_functions,)."""


class Round(NamedTuple):
    """A part of a chain, from its head until that is visited again or the part is left."""

    head: int
    """Number of the function at which the round is entered and ends."""
    functions: frozenset[int]
    """Numbers of the functions in the round, `head` among them."""

    def ends_at(self, function: int) -> bool:
        """Whether going to a function ends the round."""
        return function == self.head or function not in self.functions


class HiddenChain:
    """The chain with its parameters multiplied by `factors`: 0 never fails, infinity always."""

    kind_of_trees = RestTrees

    def __init__(
        self,
        states: HiddenStates,
        factors: Mapping[str, float] | None = None,
        *,
        base: HiddenChain | None = None,
    ) -> None:
        """Prepare the chain; raise ModelError, with the state, when a tree cannot be solved.

        What is alike in `base`, a chain of the same states or without groups, is taken from it.
        """
        self.states = states
        self._factors = factors or {}
        same = base if base and base._factors == self._factors else None
        self.values: list[dict[str, float]] = (
            same.values if same else [self._values(f.state.probabilities) for f in states.functions]
        )
        trees = same.trees if same else self.kind_of_trees(states.functions, self.values)
        self.trees: RestTrees = trees
        self.rest: list[Probability] = []
        self.units: list[dict[int, float]] = []
        self._spreads: list[dict[int, Spread]] = []
        self._latent: list[dict[tuple[int, int | None], Probability]] = []
        self._exceeding: list[dict[tuple[int, int | None], float]] = []
        self._worst: dict[int, Probability] = {}
        self._layers: dict[tuple[int, Round | None], Elimination] = {}
        self.spares = [function.spares for function in states.functions]
        # How many units may fail at once in a visit that is survived.
        self._limits = [
            max((part.threshold - 1 for part in function.parts), default=0)
            for function in states.functions
        ]
        for number, function in enumerate(states.functions):
            values = self.values[number]
            units = {c: values[name] for c, name in function.parameters.items()}
            known = base.rest[number] if base and base.values[number] == values else None
            self.rest.append(known or self.trees.failure(number))
            self.units.append(units)
            like = base if base and base.units[number] == units else None
            self._spreads.append(like._spreads[number] if like else {})
            self._latent.append(like._latent[number] if like else {})
            self._exceeding.append(like._exceeding[number] if like else {})

    def _values(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the probabilities of one function in this chain, from those of the model."""
        scaled = dict(values)
        for name, factor in self._factors.items():
            if name in scaled:
                scaled[name] = 1.0 if factor == math.inf else min(1.0, factor * scaled[name])
        return scaled

    def flow(self, start: Sequence[float] | None = None, *, cut: Round | None = None) -> Flow:
        """Return the flow of missions that start at the entry, in layer l with `start[l]`.

        Without `start`, no unit has failed. With `cut`, it is one round, from its head on.
        """
        states = self.states
        functions = list(enumerate(states.functions))
        layers, size = len(states.hidden), len(functions)
        beginning = [1.0] if start is None else start
        # What each function sends into each layer, from layers before it.
        entering = [[0.0] * size for _ in range(layers + 1)]
        visits: list[tuple[float, ...]] = []
        failures: list[tuple[float, ...]] = []
        done, back = [0.0] * (layers + 1), [0.0] * (layers + 1)
        arriving: list[float] = []
        for layer in range(layers + 1):
            arriving = [0.0] * size
            if layer < len(beginning):
                arriving[states.entry if cut is None else cut.head] = beginning[layer]
            self._follow(entering[layer], arriving, cut)
            here, failed = [0.0] * size, [0.0] * size
            leaving = entering[layer]
            if any(arriving):
                here = self._layer(layer, cut).left(arriving)
                for number, count in enumerate(here):
                    if count != 0.0:
                        failed[number], ways = self._passed(number, layer, count)
                        for to, going in ways:
                            entering[to][number] += going
            visits.append(tuple(here))
            failures.append(tuple(failed))
            done[layer] = total(leaving[number] * function.done for number, function in functions)
            if cut is not None:
                back[layer] = total(
                    leaving[number] * weight
                    for number, function in functions
                    for target, weight in function.steps
                    if cut.ends_at(target)
                )
        return Flow(tuple(visits), tuple(failures), tuple(done), tuple(back), tuple(arriving))

    def pass_once(self, number: int, start: Sequence[float]) -> tuple[list[float], float]:
        """Return what survives one visit, by layer, and what fails; `start` is by layer."""
        after = [0.0] * (len(self.states.hidden) + 1)
        failed = []
        for layer, mass in enumerate(start):
            if mass != 0.0:
                lost, ways = self._passed(number, layer, mass)
                failed.append(lost)
                for to, going in ways:
                    after[to] += going
        return after, math.fsum(failed)

    def _passed(
        self, number: int, layer: int, mass: float
    ) -> tuple[float, list[tuple[int, float]]]:
        """Return what fails of a mass in one visit, and what goes on in which layers."""
        layers = len(self.states.hidden)
        if layer == layers:
            worst = self._beyond(number)
            return mass * worst.p, [(layers, mass * worst.q)]
        through = mass * self.rest[number].q
        ways = [(to, through * weight) for to, weight in self.spread(number, layer)]
        if self.states.most is not None:
            ways.append((layers, through * self.exceeding(number, layer)))
        return mass * self.visit(number, layer).p, ways

    def _follow(self, leaving: Sequence[float], arriving: list[float], cut: Round | None) -> None:
        """Add to the arrivals at each function what leaves the others."""
        for mass, function in zip(leaving, self.states.functions, strict=True):
            if mass != 0.0:
                for target, weight in function.steps:
                    if cut is None or not cut.ends_at(target):
                        arriving[target] += mass * weight

    def successes(self) -> tuple[tuple[float, ...], ...]:
        """Return by layer and function the probability of success after a visit that led there.

        More failures than the states hold count as no success.
        """
        successes: list[tuple[float, ...]] = [()] * len(self.states.hidden)
        for layer in range(len(successes) - 1, -1, -1):
            reward = []
            for number, function in enumerate(self.states.functions):
                parts = [
                    weight * (function.done if to == layer else successes[to][number])
                    for to, weight in self.spread(number, layer)
                ]
                reward.append(self.rest[number].q * total(parts))
            from_each = self._layer(layer, None).right(reward)
            successes[layer] = tuple(
                function.done
                + total(weight * from_each[target] for target, weight in function.steps)
                for function in self.states.functions
            )
        return tuple(successes)

    def returns(self) -> list[float]:
        """Return how often each function is visited from a visit on, without hidden failures."""
        return self._layer(0, None).returns()

    def visit(self, number: int, layer: int, fewer: int | None = None) -> Probability:
        """Return the probability that one visit fails; class `fewer` has one working unit less."""
        rest = self.rest[number]
        if not self.states.functions[number].parts:
            return rest
        latent = self.latent_failure(number, layer, fewer)
        return Probability(rest.p + rest.q * latent.p, rest.q * latent.q)

    def latent_failure(self, number: int, layer: int, fewer: int | None = None) -> Probability:
        """Return the probability that the latent units fail a visit."""
        cache = self._latent[number]
        key = (layer, fewer)
        if key not in cache:
            parts = self.states.functions[number].parts
            cache[key] = any_of([self.part_failure(number, part, layer, fewer) for part in parts])
        return cache[key]

    def part_failure(
        self, number: int, part: Part, layer: int, fewer: int | None = None
    ) -> Probability:
        """Return the probability that so many units of a part fail that the visit does."""
        counts, reached = self._failures(number, part, layer, fewer)
        return Probability(reached, total(counts))

    def spread(
        self, number: int, layer: int, chosen: Mapping[int, Sequence[float]] | None = None
    ) -> Spread:
        """Return the layers to which a visit leads that the latent units do not fail.

        The failures of the other part of the tree are left aside. `chosen` replaces the
        distribution of how many units of a class fail.
        """
        cache = self._spreads[number]
        if chosen is None and layer in cache:
            return cache[layer]
        states = self.states
        held = states.held[number]
        pairs = [(layer, 1.0)] if held[layer] else []
        for unit_class, p in self.units[number].items():
            if chosen is not None and unit_class in chosen:
                counts = chosen[unit_class]
            else:
                counts = self._counts(number, layer, unit_class, p)
            grown = []
            for reached, weight in pairs:
                for failed, share in enumerate(counts):
                    if failed > 0:
                        reached = states.more[reached][unit_class]
                        if reached < 0 or not held[reached]:
                            break
                    if share != 0.0:
                        grown.append((reached, weight * share))
            pairs = grown
        spread = tuple(pairs)
        if chosen is None:
            cache[layer] = spread
        return spread

    def _counts(self, number: int, layer: int, unit_class: int, p: float) -> Sequence[float]:
        """Return how many more units of a class fail in a visit that it does not fail."""
        if unit_class in self.spares[number]:
            return self.spare_outcome(number, layer, unit_class).survived
        return failure_counts(self.states.working(layer, unit_class), p, self._limits[number])

    def spare_outcome(self, number: int, layer: int, unit_class: int) -> Outcome:
        """Return what comes of a group with spares in a visit."""
        group, lost = self.spares[number][unit_class], self.states.hidden[layer][unit_class]
        if lost > group.units - group.required:
            return Outcome((), 1.0)
        return group.visit(unit_pair(self.units[number][unit_class]), lost)

    def exceeding(self, number: int, layer: int, fewer: int | None = None) -> float:
        """Return the probability that the latent units survive with more failed than is held."""
        most = self.states.most
        if most is None:
            return 0.0
        cache, key = self._exceeding[number], (layer, fewer)
        if key not in cache:
            parts = self.states.functions[number].parts
            own = [self._failures(number, part, layer, fewer)[0] for part in parts]
            cache[key] = self._more_than(most - sum(self.states.hidden[layer]), own)
        return cache[key]

    def exceeding_with(
        self, number: int, layer: int, part: Part, counts: tuple[float, ...]
    ) -> float:
        """Return `exceeding` where so many units of one part fail, as `counts` says."""
        most = self.states.most
        if most is None:
            return 0.0
        own = [
            counts if other == part else self._failures(number, other, layer, None)[0]
            for other in self.states.functions[number].parts
        ]
        return self._more_than(most - sum(self.states.hidden[layer]), own)

    @staticmethod
    def _more_than(room: int, parts: Sequence[Sequence[float]]) -> float:
        """Return the probability that more units than `room` fail, of counts of each part."""
        counts, beyond = [1.0], 0.0
        for own in parts:
            beyond *= total(own)
            grown = [0.0] * (room + 1)
            for before, share in enumerate(counts):
                for failed, p in enumerate(own):
                    if before + failed > room:
                        beyond += share * p
                    else:
                        grown[before + failed] += share * p
            counts = grown
        return beyond

    def _failures(
        self, number: int, part: Part, layer: int, fewer: int | None
    ) -> tuple[tuple[float, ...], float]:
        """Return how many more units of a part fail, short of its failure, and that failure."""
        hidden, units = self.states.hidden[layer], self.units[number]
        if part.spares is not None:
            outcome = self.spare_outcome(number, layer, part.classes[0])
            return outcome.survived, outcome.failed
        return group_failures(
            tuple((self.states.working(layer, c) - (c == fewer), units[c]) for c in part.classes),
            part.threshold - sum(hidden[c] for c in part.classes),
        )

    def _layer(self, layer: int, cut: Round | None) -> Elimination:
        key = (layer, cut)
        if key not in self._layers:
            rows, exits = [], []
            for number, function in enumerate(self.states.functions):
                stay, leave = self._stay(number, layer)
                row: dict[int, float] = {}
                for target, weight in function.steps:
                    if cut is not None and cut.ends_at(target):
                        leave += stay * weight
                    elif target != number:
                        row[target] = stay * weight
                rows.append(row)
                exits.append(leave + stay * function.done)
            self._layers[key] = Elimination(self.states.pattern, rows, exits)
        return self._layers[key]

    def _stay(self, number: int, layer: int) -> tuple[float, float]:
        """Return the probability that a visit goes on within its layer, and its complement."""
        if layer == len(self.states.hidden):
            worst = self._beyond(number)
            return worst.q, worst.p
        q = self.rest[number].q
        stay, leave = 0.0, [self.visit(number, layer).p, q * self.exceeding(number, layer)]
        for reached, weight in self.spread(number, layer):
            if reached == layer:
                stay = q * weight
            else:
                leave.append(q * weight)
        return stay, total(leave)

    def _beyond(self, number: int) -> Probability:
        """Return a bound from above of the failure of a visit with more failed units than are held.

        Each part is taken to need only one more failure to fail, with its least reliable units
        still working; where another function tolerates more of the same units, it may have failed
        already.
        """
        if number not in self._worst:
            self._worst[number] = any_of(self._one_short(number))
        return self._worst[number]

    def _one_short(self, number: int) -> list[Probability]:
        """Return the failures of the rest of the tree and of units that would now fail a part."""
        states = self.states
        pairs = [self.rest[number]]
        for part in states.functions[number].parts:
            if any(other != part for c in part.classes for other in states.parts_of[c]):
                return [Probability(1.0, 0.0)]
            units = sorted(
                (self.units[number][c] for c in part.classes for _ in states.classes[c]),
                reverse=True,
            )
            pairs += map(pair_of, units[: len(units) - part.threshold + 1])
        return pairs


def unit_pair(p: float) -> Probability:
    """Return the pair of a unit's probability; it may carry a derivative, see `pair_importance`."""
    return Probability(p, 1.0 - p) if isinstance(p, complex) else pair_of(p)
