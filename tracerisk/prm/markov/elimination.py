"""Elimination of a small chain, in plain Python.

Grassmann, Taksar and Heyman, "Regenerative analysis and steady state distributions for Markov
chains", Operations Research 33 (1985): states leave the chain one by one, and what leaves a
state is the sum of its ways out, never one minus what stays.
"""

from __future__ import annotations

import heapq
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass


class StuckStateError(ArithmeticError):
    """A state is left with a weight too small for double precision; `state` is its index."""

    def __init__(self, state: int) -> None:
        super().__init__(state)
        self.state = state


class FilledInError(ArithmeticError):
    """Elimination takes more products than it was given."""


@dataclass(frozen=True, slots=True)
class _Step:
    """One state leaving the chain: who led to it, and the shares of where it leads."""

    state: int
    incoming: Mapping[int, float]
    leaving: float
    outgoing: Mapping[int, float]


@dataclass(frozen=True, slots=True)
class SmallFactors:
    """A chain after elimination.

    With W the weights between states and s all that leaves each, G is diag(s) - W.
    """

    size: int
    _steps: tuple[_Step, ...]

    def left(self, start: Sequence[float]) -> list[float]:
        """Return u with u G = start; neither holds a negative number."""
        moved = list(start)
        for step in self._steps:
            mass = moved[step.state]
            if mass:
                for target, share in step.outgoing.items():
                    moved[target] += mass * share
        for step in reversed(self._steps):
            arrivals = math.fsum(moved[source] * p for source, p in step.incoming.items())
            moved[step.state] = (moved[step.state] + arrivals) / step.leaving
        return moved

    def right(self, reward: Sequence[float]) -> list[float]:
        """Return x with G x = reward; neither holds a negative number."""
        value = list(reward)
        for step in self._steps:
            value[step.state] /= step.leaving
            if value[step.state]:
                for source, p in step.incoming.items():
                    value[source] += p * value[step.state]
        for step in reversed(self._steps):
            onward = math.fsum(share * value[target] for target, share in step.outgoing.items())
            value[step.state] += onward
        return value


def eliminate(
    ways: Sequence[Mapping[int, float]], slack: Sequence[float], most_products: int | None = None
) -> SmallFactors:
    """Take the states out of a chain, those with the fewest ways through them first.

    `ways[i][j]` is the weight of going from `i` to another state `j`, `slack[i]` that of leaving
    them all.
    Without a state k, i leads to j with W_ij + W_ik W_kj / S_k, where S_k is the sum of the ways
    out of k; the way back to oneself is never needed, for S_k holds all of it.
    Raises StuckStateError when a state is left with less than the smallest normal double, and
    FilledInError when more than `most_products` products of weights are needed.
    """
    products = 0
    rows = [{target: p for target, p in row.items() if p > 0.0} for row in ways]
    ends = list(slack)
    columns: list[set[int]] = [set() for _ in rows]
    for state, row in enumerate(rows):
        row.pop(state, None)
        for target in row:
            columns[target].add(state)
    # Any order is as exact; this one keeps sparse chains sparse.
    costs = [len(row) * len(column) for row, column in zip(rows, columns, strict=True)]
    queue = [(cost, state) for state, cost in enumerate(costs)]
    heapq.heapify(queue)
    steps: list[_Step] = []
    while len(steps) < len(rows):
        cost, state = heapq.heappop(queue)
        if cost != costs[state]:
            continue
        costs[state] = -1
        row = rows[state]
        leaving = math.fsum((*row.values(), ends[state]))
        if leaving < sys.float_info.min:
            raise StuckStateError(state)
        products += cost
        if most_products is not None and products > most_products:
            raise FilledInError
        outgoing = {target: p / leaving for target, p in row.items()}
        end_share = ends[state] / leaving
        incoming = {}
        for source in sorted(columns[state]):
            into = rows[source]
            p = into.pop(state)
            incoming[source] = p
            ends[source] += p * end_share
            for target, share in outgoing.items():
                if target != source:
                    into[target] = into.get(target, 0.0) + p * share
                    columns[target].add(source)
        for target in outgoing:
            columns[target].discard(state)
        for touched in {*incoming, *outgoing}:
            now = len(rows[touched]) * len(columns[touched])
            if now != costs[touched]:
                costs[touched] = now
                heapq.heappush(queue, (now, touched))
        steps.append(_Step(state, incoming, leaving, outgoing))
    return SmallFactors(len(rows), tuple(steps))
