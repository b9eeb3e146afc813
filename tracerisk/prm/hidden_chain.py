"""The chain of a model with hidden failures, for one assignment of its parameters.

A visit of a function in a hidden state fails, or goes on with the same units failed or with more.
So the chain falls into layers, one for each hidden state, which are left for others but never
come back: each is eliminated by itself (`elimination`), and what leaves one enters later ones.
Every number is a sum of products of probabilities; nothing is subtracted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tracerisk.errors import ModelError
from tracerisk.prm.binomial import failure_counts, failure_tails
from tracerisk.prm.elimination import Elimination
from tracerisk.prm.fault_tree import FaultTree
from tracerisk.prm.hidden_states import Hidden, HiddenStates, Part
from tracerisk.prm.probability import Probability, at_least

Spread = tuple[tuple[int, float], ...]
"""The hidden states that a visit leaves, by number, each with its probability."""


@dataclass(frozen=True, slots=True)
class Flow:
    """What flows through the chain from a start: by layer and function, by layer, by function.

    `visits[l][f]` is how often function f is visited in layer l, `failures[l][f]` how often it
    fails there, `done[l]` how often the mission ends well there, `back[l]` how often it comes back
    to the entry, where that ends a cycle. The last layer is that of more failed units than
    `hidden` holds; `beyond[f]` is how often f is the first function visited in it.
    """

    visits: tuple[tuple[float, ...], ...]
    failures: tuple[tuple[float, ...], ...]
    done: tuple[float, ...]
    back: tuple[float, ...]
    beyond: tuple[float, ...]


class HiddenChain:
    """The chain with its parameters multiplied by `factors`: 0 never fails, infinity always."""

    def __init__(
        self,
        states: HiddenStates,
        factors: Mapping[str, float] | None = None,
        *,
        base: HiddenChain | None = None,
    ) -> None:
        """Prepare the chain; `base` is one of the same states, from which is taken what is alike.

        Raises ModelError, with the state, when a tree cannot be solved.
        """
        self.states = states
        self.values = [_scaled(f.state.probabilities, factors or {}) for f in states.functions]
        self.rest: list[Probability] = []
        self.units: list[dict[int, float]] = []
        self._spreads: list[dict[Hidden, Spread]] = []
        self._visits: dict[tuple[int, Hidden, int | None], Probability] = {}
        self._layers: dict[tuple[int, bool], Elimination] = {}
        for number, function in enumerate(states.functions):
            values = self.values[number]
            units = {c: values[name] for c, name in function.parameters.items()}
            alike = base is not None and base.values[number] == values
            self.rest.append(
                base.rest[number]
                if base is not None and alike
                else tree_probability(function.state.name, function.rest, values)
            )
            self.units.append(units)
            same_units = base is not None and base.units[number] == units
            self._spreads.append(base._spreads[number] if base is not None and same_units else {})

    def flow(self, start: Sequence[float] | None = None, *, cut: bool = False) -> Flow:
        """Return the flow of missions that start at the entry, in layer l with `start[l]`.

        Without `start`, no unit has failed. With `cut`, coming back to the entry ends it.
        """
        states = self.states
        size = len(states.functions)
        layers = len(states.hidden)
        arriving = [[0.0] * size for _ in range(layers + 1)]
        for layer, mass in enumerate([1.0] if start is None else start):
            arriving[layer][states.entry] = mass
        visits: list[tuple[float, ...]] = []
        failures = [[0.0] * size for _ in range(layers + 1)]
        done, back = [0.0] * (layers + 1), [0.0] * (layers + 1)

        def leave(number: int, layer: int, mass: float, *, is_new: bool) -> None:
            function = states.functions[number]
            done[layer] += mass * function.done
            for target, weight in function.steps:
                if cut and target == states.entry:
                    back[layer] += mass * weight
                elif is_new:
                    arriving[layer][target] += mass * weight

        for layer in range(layers + 1):
            if not any(arriving[layer]):
                visits.append((0.0,) * size)
                continue
            here = self._layer(layer, cut=cut).visits(arriving[layer])
            visits.append(tuple(here))
            for number, count in enumerate(here):
                if count == 0.0:
                    continue
                if layer == layers:
                    worst = self._beyond(number)
                    failures[layer][number] = count * worst.p
                    leave(number, layer, count * worst.q, is_new=False)
                    continue
                hidden = states.hidden[layer]
                failures[layer][number] = count * self.visit(number, hidden).p
                through = count * self.rest[number].q
                for reached, weight in self.spread(number, hidden):
                    leave(number, reached, through * weight, is_new=reached != layer)
                if states.most is not None:
                    more = self.exceeding(number, hidden)
                    leave(number, layers, through * more, is_new=True)
        return Flow(
            visits=tuple(visits),
            failures=tuple(map(tuple, failures)),
            done=tuple(done),
            back=tuple(back),
            beyond=tuple(arriving[layers]),
        )

    def successes(self) -> tuple[tuple[float, ...], ...]:
        """Return by layer and function the probability of success from there.

        More failures than the states hold count as no success.
        """
        found: list[list[float]] = [[] for _ in self.states.hidden]
        for layer in range(len(found) - 1, -1, -1):
            hidden = self.states.hidden[layer]
            reward = []
            for number, function in enumerate(self.states.functions):
                parts = [
                    weight * (function.done if to == layer else self.onward(number, found[to]))
                    for to, weight in self.spread(number, hidden)
                ]
                reward.append(self.rest[number].q * math.fsum(parts))
            found[layer] = self._layer(layer, cut=False).values(reward)
        return tuple(map(tuple, found))

    def onward(self, number: int, from_each: Sequence[float]) -> float:
        """Return the success of a mission that leaves a function, from that of each function."""
        function = self.states.functions[number]
        return function.done + math.fsum(
            weight * from_each[target] for target, weight in function.steps
        )

    def visit(self, number: int, hidden: Hidden, fewer: int | None = None) -> Probability:
        """Return the probability that one visit fails; class `fewer` has one working unit less."""
        parts = self.states.functions[number].parts
        if not parts:
            return self.rest[number]
        key = (number, hidden, fewer)
        if key not in self._visits:
            pairs = [self.part_failure(number, part, hidden, fewer) for part in parts]
            self._visits[key] = at_least(1, [self.rest[number], *pairs])
        return self._visits[key]

    def part_failure(
        self, number: int, part: Part, hidden: Hidden, fewer: int | None = None
    ) -> Probability:
        """Return the probability that so many units of a part fail that the visit does."""
        counts, reached = self._part_counts(number, part, hidden, fewer)
        return Probability(reached, math.fsum(counts))

    def spread(
        self,
        number: int,
        hidden: Hidden,
        chosen: Mapping[int, Sequence[float]] | None = None,
    ) -> Spread:
        """Return the hidden states that a visit leaves which the latent units do not fail.

        The failures of the other part of the tree are left aside. `chosen` replaces the
        distribution of how many units of a class fail.
        """
        cache = self._spreads[number]
        if chosen is None and hidden in cache:
            return cache[hidden]
        states, function = self.states, self.states.functions[number]
        found = [(hidden, 1.0)] if states.is_held(function, hidden) else []
        for unit_class, p in self.units[number].items():
            if chosen is not None and unit_class in chosen:
                counts = chosen[unit_class]
            else:
                counts = failure_counts(self._working(hidden, unit_class), p, self._limit(number))
            grown = []
            for state, weight in found:
                for failed, share in enumerate(counts):
                    if failed > 0:
                        state = states.with_one_more(state, unit_class)
                        if not states.is_held(function, state):
                            break
                    if share > 0.0:
                        grown.append((state, weight * share))
            found = grown
        spread = tuple((states.index[state], weight) for state, weight in found)
        if chosen is None:
            cache[hidden] = spread
        return spread

    def exceeding(self, number: int, hidden: Hidden, fewer: int | None = None) -> float:
        """Return the probability that the latent units survive with more failed than is held."""
        most = self.states.most
        if most is None:
            return 0.0
        room = most - sum(hidden)
        counts, beyond = [1.0], 0.0
        for part in self.states.functions[number].parts:
            own, _ = self._part_counts(number, part, hidden, fewer)
            beyond *= math.fsum(own)
            grown = [0.0] * (room + 1)
            for before, share in enumerate(counts):
                for failed, p in enumerate(own):
                    if before + failed > room:
                        beyond += share * p
                    else:
                        grown[before + failed] += share * p
            counts = grown
        return beyond

    def _part_counts(
        self, number: int, part: Part, hidden: Hidden, fewer: int | None
    ) -> tuple[list[float], float]:
        """Return how many more units of a part fail, short of its failure, and that failure."""
        room = part.threshold - sum(hidden[c] for c in part.classes)
        if room <= 0:
            return [], 1.0
        counts, reached = [1.0], 0.0
        for unit_class in part.classes:
            units = self._working(hidden, unit_class) - (unit_class == fewer)
            p = self.units[number][unit_class]
            own = failure_counts(units, p, room - 1)
            tails = (1.0, *failure_tails(units, p, room))
            grown = [0.0] * min(room, len(counts) + len(own) - 1)
            for before, share in enumerate(counts):
                if room - before < len(tails):
                    reached += share * tails[room - before]
                for failed, one in enumerate(own[: room - before]):
                    grown[before + failed] += share * one
            counts = grown
        return counts, reached

    def _working(self, hidden: Hidden, unit_class: int) -> int:
        return len(self.states.classes[unit_class]) - hidden[unit_class]

    def _limit(self, number: int) -> int:
        """Return how many units may fail at once in a visit that is survived."""
        return max((part.threshold - 1 for part in self.states.functions[number].parts), default=0)

    def _layer(self, layer: int, *, cut: bool) -> Elimination:
        key = (layer, cut)
        if key not in self._layers:
            rows, exits = [], []
            for number, function in enumerate(self.states.functions):
                stay, leave = self._stay(number, layer)
                row: dict[int, float] = {}
                for target, weight in function.steps:
                    if cut and target == self.states.entry:
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
        hidden = self.states.hidden[layer]
        q = self.rest[number].q
        stay, leave = 0.0, [self.visit(number, hidden).p, q * self.exceeding(number, hidden)]
        for reached, weight in self.spread(number, hidden):
            if reached == layer:
                stay = q * weight
            else:
                leave.append(q * weight)
        return stay, math.fsum(leave)

    def _beyond(self, number: int) -> Probability:
        """Return the failure probability of a visit with more failed units than are held, at most.

        Each part of the tree is taken to be one failure away from its own, with the units that
        fail most still working; where another function tolerates more of the same units, it may
        have failed already.
        """
        functions = self.states.functions
        pairs = [self.rest[number]]
        for part in functions[number].parts:
            others = {each for function in functions for each in function.parts} - {part}
            if any(set(part.classes) & set(other.classes) for other in others):
                return Probability(1.0, 0.0)
            units = sorted(
                (
                    self.units[number][c]
                    for c in part.classes
                    for _ in range(len(self.states.classes[c]))
                ),
                reverse=True,
            )
            pairs += map(Probability.of, units[: len(units) - part.threshold + 1])
        return at_least(1, pairs)


def tree_probability(state: str, tree: FaultTree, values: Mapping[str, float]) -> Probability:
    """Return the top's probability; raise ModelError with the state where it cannot be had."""
    try:
        return tree.probability(values)
    except ModelError as error:
        raise ModelError(f"state '{state}': {error.message}", error.location) from error


def _scaled(values: Mapping[str, float], factors: Mapping[str, float]) -> dict[str, float]:
    scaled = dict(values)
    for name, factor in factors.items():
        if name in scaled:
            scaled[name] = 1.0 if factor == math.inf else min(1.0, factor * scaled[name])
    return scaled
