"""Absorbing Markov chains in discrete time, solved without a single subtraction."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tracerisk.errors import ModelError, one_of

_ROW_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True)
class MarkovChain:
    """An absorbing chain: a row of transition probabilities per transient state.

    `transitions[s][t]` is the probability of going from `s` to `t`, a transient or an absorbing
    state; what is not listed is zero.
    Rows are normalised: each is read as divided by its sum.
    Raises ModelError when a name is used twice or unknown, an entry is negative or not finite,
    a row's sum differs from one by more than 1e-9, or a state can never be absorbed.
    """

    transitions: Mapping[str, Mapping[str, float]]
    absorbing: tuple[str, ...]

    def __post_init__(self) -> None:
        known: set[str] = set()
        for name in (*self.transitions, *self.absorbing):
            if name in known:
                raise ModelError(f"state '{name}' stands twice in the chain; rename one")
            known.add(name)
        for state, row in self.transitions.items():
            _check_row(state, row, known)
        _check_absorbed(self)

    def solve(self, entry: str) -> ChainSolution:
        """Solve the chain that starts in the transient state `entry`.

        Grassmann, Taksar and Heyman, "Regenerative analysis and steady state distributions for
        Markov chains", Operations Research 33 (1985): states are eliminated one by one, and
        the probability of leaving a state is the sum of its ways out, never one minus the
        probability of staying.
        Each result then has a relative error of a few units in the last place for each state,
        whatever the size of the numbers and however rarely the chain is absorbed.
        Raises ModelError when `entry` is no transient state, or when some state is left less
        often than the smallest number of double precision.
        """
        if entry not in self.transitions:
            raise ModelError(
                f"the entry '{entry}' is no transient state; {one_of(self.transitions, entry)}"
            )
        return ChainSolution(self, entry, _eliminate(self, entry))


@dataclass(frozen=True, slots=True)
class _Elimination:
    """One state leaving the chain: who led to it, and where it leads once it is left."""

    state: str
    incoming: Mapping[str, float]
    leaving: float
    outgoing: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class ChainSolution:
    """An absorbing chain after elimination; `entry` was eliminated last."""

    chain: MarkovChain
    entry: str
    _steps: tuple[_Elimination, ...]

    def expected_visits(self) -> dict[str, float]:
        """Return how often each transient state is visited, the start counted as a visit."""
        visits: dict[str, float] = {}
        for step in reversed(self._steps):
            arrivals = math.fsum(visits[state] * p for state, p in step.incoming.items())
            # The entry comes first here, with no state left that leads to it but the start.
            start = 1.0 if step.state == self.entry else 0.0
            visits[step.state] = (start + arrivals) / step.leaving
        return {state: visits[state] for state in self.chain.transitions}

    def absorption(self) -> dict[str, float]:
        """Return for each absorbing state the probability of ending there."""
        outgoing = self._steps[-1].outgoing
        return {state: outgoing.get(state, 0.0) for state in self.chain.absorbing}

    def absorption_from_each(self, targets: Iterable[str]) -> dict[str, float]:
        """Return from each transient state the probability of ending in one of `targets`.

        Raises ModelError when a target is no absorbing state.
        """
        reached = dict.fromkeys(self.chain.absorbing, 0.0)
        for target in targets:
            if target not in reached:
                raise ModelError(
                    f"'{target}' is no absorbing state; {one_of(self.chain.absorbing, target)}"
                )
            reached[target] = 1.0
        for step in reversed(self._steps):
            reached[step.state] = math.fsum(
                p * reached[state] for state, p in step.outgoing.items()
            )
        return {state: reached[state] for state in self.chain.transitions}


def _check_row(state: str, row: Mapping[str, float], known: set[str]) -> None:
    for target, p in row.items():
        if target not in known:
            raise ModelError(
                f"state '{state}': '{target}' is no state of the chain; {one_of(known, target)}"
            )
        if not 0.0 <= p < math.inf:
            raise ModelError(f"state '{state}': {p!r} to '{target}' is no probability")
    total = math.fsum(row.values())
    if abs(total - 1.0) > _ROW_TOLERANCE:
        raise ModelError(f"state '{state}': its transitions sum to {total!r}; they must sum to 1")


def _check_absorbed(chain: MarkovChain) -> None:
    sources: dict[str, list[str]] = {}
    for state, row in chain.transitions.items():
        for target, p in row.items():
            if p > 0.0:
                sources.setdefault(target, []).append(state)
    absorbed = set(chain.absorbing)
    waiting = list(chain.absorbing)
    while waiting:
        for state in sources.get(waiting.pop(), []):
            if state not in absorbed:
                absorbed.add(state)
                waiting.append(state)
    caught = [state for state in chain.transitions if state not in absorbed]
    if caught:
        raise ModelError(
            f"the chain never ends once in {', '.join(caught)}; "
            f"lead each to an absorbing state ({', '.join(chain.absorbing) or 'there is none'})"
        )


def _eliminate(chain: MarkovChain, entry: str) -> tuple[_Elimination, ...]:
    """Take the transient states out of the chain, `entry` last.

    The chain without a state k leads from i to j by P_ij + P_ik P_kj / S_k, where S_k is the
    sum of the ways out of k.
    The way back to oneself is never stored: S_k holds all that is needed of it.
    """
    rows: dict[str, dict[str, float]] = {}
    columns: dict[str, set[str]] = {state: set() for state in chain.transitions}
    for state, given in chain.transitions.items():
        total = math.fsum(given.values())
        rows[state] = {t: p / total for t, p in given.items() if p > 0.0 and t != state}
        for target in rows[state]:
            if target in columns:
                columns[target].add(state)
    rank = {state: index for index, state in enumerate(rows)}
    remaining = set(rows)
    steps = []
    while remaining:
        # Least fill-in first: any order is as exact, this one keeps sparse chains sparse.
        candidates = remaining - {entry} or {entry}
        state = min(candidates, key=lambda s: (len(rows[s]) * len(columns[s]), rank[s]))
        row = rows.pop(state)
        leaving = math.fsum(row.values())
        if leaving < sys.float_info.min:
            raise ModelError(
                f"state '{state}' is left with a probability below {sys.float_info.min:.0e}, "
                "too small for a number of double precision; leave out what never happens"
            )
        outgoing = {target: p / leaving for target, p in row.items()}
        incoming = {}
        for source in sorted(columns.pop(state), key=rank.__getitem__):
            p = rows[source].pop(state)
            incoming[source] = p
            for target, share in outgoing.items():
                if target != source:
                    rows[source][target] = rows[source].get(target, 0.0) + p * share
                    if target in columns:
                        columns[target].add(source)
        for target in outgoing:
            if target in columns:
                columns[target].discard(state)
        remaining.discard(state)
        steps.append(_Elimination(state, incoming, leaving, outgoing))
    return tuple(steps)
