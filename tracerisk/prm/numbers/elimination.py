"""Subtraction-free elimination on one sparse pattern, for many matrices and right sides.

Grassmann, Taksar and Heyman, "Regenerative analysis and steady state distributions for Markov
chains", Operations Research 33 (1985), on states that are numbered: what a state keeps of itself
is never stored, its ways out are. What leaves a state is the sum of these, never one minus what
stays.
The layers of a chain with hidden failures share their pattern; it is analysed once.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from heapq import heapify, heappop, heappush

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import total

Rows = Sequence[Mapping[int, float]]
"""For each state the probability, or another weight, of going to each other state."""
Label = Callable[[int], str]
"""The words for a state, by its index."""


class StuckStateError(ModelError):
    """A state is left with a weight too small for double precision.

    `kind` is what a weight is: a probability or a rate.
    """

    def __init__(self, state: str, kind: str) -> None:
        super().__init__(
            f"state {state} is left with a {kind} below {sys.float_info.min:.0e}, "
            "too small for double precision; remove transitions that never happen"
        )


class FilledInError(ArithmeticError):
    """Elimination takes more products than it was given."""


class Pattern:
    """Which state leads to which, and the order in which they are eliminated."""

    def __init__(
        self,
        label: Label,
        targets: Sequence[Collection[int]],
        kind: str = "probability",
        most_products: int | None = None,
    ) -> None:
        """Analyse a chain in which state i leads to `targets[i]`.

        `label` and `kind` are for messages.
        Raises FilledInError when more than `most_products` products of weights are needed.
        """
        self.label, self.kind = label, kind
        after = [set(row) - {state} for state, row in enumerate(targets)]
        before: list[set[int]] = [set() for _ in after]
        for state, row in enumerate(after):
            for target in row:
                before[target].add(state)
        # Least fill-in first: any order is as exact, this one keeps sparse chains sparse.
        waiting = [(len(a) * len(b), k) for k, (a, b) in enumerate(zip(after, before, strict=True))]
        heapify(waiting)
        gone: set[int] = set()
        steps = []
        products = 0
        while waiting:
            weight, state = heappop(waiting)
            if state in gone:
                continue
            now = len(after[state]) * len(before[state])
            if now > weight:
                heappush(waiting, (now, state))
                continue
            gone.add(state)
            products += now
            if most_products is not None and products > most_products:
                raise FilledInError
            sources, following = sorted(before[state]), sorted(after[state])
            steps.append((state, tuple(sources), tuple(following)))
            for source in sources:
                after[source].discard(state)
                after[source].update(target for target in following if target != source)
            for target in following:
                before[target].discard(state)
                before[target].update(source for source in sources if source != target)
            for other in {*sources, *following}:
                heappush(waiting, (len(after[other]) * len(before[other]), other))
        self.steps = tuple(steps)


_Ways = tuple[Sequence[int], Sequence[float]]
_Step = tuple[int, float, tuple[_Ways, _Ways]]
"""A state, the weight that leaves it, and the ways into it and out of it."""
_INTO, _OUT = 0, 1


class Elimination:
    """The matrix I - P of a chain after elimination, `P` given by its rows and ways out."""

    def __init__(self, pattern: Pattern, rows: Rows, exits: Sequence[float]) -> None:
        """Eliminate; `exits` is the probability of each state to leave the chain.

        What a row holds of its own state is not read: it is what the others leave of one.
        With weights that do not sum to one, such as rates, I - P is diag(s) - W: `W` holds the
        weights between states, s what leaves each of them.
        Raises StuckStateError when a state is left with less than the smallest normal double.
        """
        left = [dict(row) for row in rows]
        ways_out = list(exits)
        done: list[_Step] = []
        for state, sources, following in pattern.steps:
            row = left[state]
            outgoing = [row.get(target, 0.0) for target in following]
            leaving = total((ways_out[state], *outgoing))
            if abs(leaving) < sys.float_info.min:
                raise StuckStateError(pattern.label(state), pattern.kind)
            incoming = []
            for source in sources:
                there = left[source]
                p = there.pop(state, 0.0)
                incoming.append(p)
                if p != 0.0:
                    share = p / leaving
                    ways_out[source] += share * ways_out[state]
                    for target, way in zip(following, outgoing, strict=True):
                        if target != source and way != 0.0:
                            there[target] = there.get(target, 0.0) + share * way
            done.append((state, leaving, ((sources, incoming), (following, outgoing))))
        self._done = done

    def left(self, start: Sequence[float]) -> list[float]:
        """Return x with x (I - P) = `start`: how often each state is visited."""
        return self._solved(start, _INTO, _OUT)

    def right(self, reward: Sequence[float]) -> list[float]:
        """Return x with (I - P) x = `reward`: what each state collects until the chain is left."""
        return self._solved(reward, _OUT, _INTO)

    def _solved(self, given: Sequence[float], back: int, onward: int) -> list[float]:
        """Pass `given` on along the ways of one side, and collect it by those of the other."""
        mass = list(given)
        for state, leaving, ways in self._done:
            share = mass[state] / leaving
            if share != 0.0:
                for other, way in zip(*ways[onward], strict=True):
                    mass[other] += share * way
        for state, leaving, ways in reversed(self._done):
            collected = mass[state]
            for other, way in zip(*ways[back], strict=True):
                collected += mass[other] * way
            mass[state] = collected / leaving
        return mass

    def returns(self) -> list[float]:
        """Return how often each state is visited by a chain that starts there.

        The diagonal of the inverse of I - P, from the entries of the inverse on the pattern after
        elimination: the entries of a state follow from those of the states eliminated after it.
        K.
        Takahashi, J. Fagan and M.-S. Chin, 8th PICA Conference (1973).
        """
        # tables[a][b] is how often b is visited from a.
        tables: list[dict[int, float]] = [{} for _ in self._done]
        for state, leaving, ((sources, incoming), (following, outgoing)) in reversed(self._done):
            onward = tables[state]
            for source in sources:
                onward[source] = (
                    sum(
                        way * tables[target][source]
                        for target, way in zip(following, outgoing, strict=True)
                    )
                    / leaving
                )
            for target in following:
                there = tables[target]
                there[state] = (
                    sum(there[s] * way for s, way in zip(sources, incoming, strict=True)) / leaving
                )
            back = (way * tables[t][state] for t, way in zip(following, outgoing, strict=True))
            onward[state] = (1.0 + sum(back)) / leaving
        return [row[state] for state, row in enumerate(tables)]
