"""Absorbing Markov chains in discrete time, by the names of their states."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.common.strong_components import reached
from tracerisk.errors import ModelError, one_of
from tracerisk.prm.display import DisplayedGraph
from tracerisk.prm.other_models.markov.solution import ChainSolution
from tracerisk.prm.other_models.markov.solver import solver_of
from tracerisk.prm.other_models.markov.steps import distribution_after

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.large.matrix_chain import MatrixChain

_ROW_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True)
class MarkovChain(DisplayedGraph):
    """An absorbing chain: a row of transition probabilities per transient state.

    Rows are normalised: each is read as divided by its sum.

    Raises ModelError when a name is used twice or unknown, an entry is negative or not finite,
    a row's sum differs from one by more than 1e-9, or a state can never be absorbed.
    """

    transitions: Mapping[str, Mapping[str, float]]
    """Probability of going to each target, by transient state and target; not listed is zero."""
    absorbing: tuple[str, ...]
    """Names of the absorbing states, which have no row."""

    def __post_init__(self) -> None:
        known = distinct_names(self.transitions, self.absorbing)
        for state, row in self.transitions.items():
            check_targets(state, row, known, "probability")
            _check_sum(state, row)
        check_absorbed(self.transitions, self.absorbing)

    @classmethod
    def of(cls, rows: Mapping[str, Mapping[str, float]]) -> MarkovChain:
        """Return the chain whose absorbing states are those that have no row.

        Raises ModelError as the class does.
        """
        ends = dict.fromkeys(target for row in rows.values() for target in row)
        return cls(rows, tuple(name for name in ends if name not in rows))

    @staticmethod
    def from_matrix(
        matrix: Any, absorbing: Any = None, names: Sequence[str] | None = None
    ) -> MatrixChain:
        """Return the chain of a square matrix, whose results are arrays by state.

        matrix: (n, n), a NumPy array or a SciPy sparse array, `matrix[i, j]` the probability of
        going from i to j; absorbing: the indices of the absorbing states, or (n,) of booleans,
        or `None` for all that lead to nothing but themselves; names: n names, or none.
        Raises ModelError as MarkovChain does.
        """
        from tracerisk.prm.other_models.markov.large.matrix_chain import MatrixChain

        return MatrixChain.from_matrix(matrix, absorbing, names)

    def solve(self, entry: str) -> ChainSolution:
        """Solve the chain that starts in the transient state `entry`.

        Grassmann, Taksar and Heyman, "Regenerative analysis and steady state distributions for
        Markov chains", Operations Research 33 (1985): states are eliminated one by one, and
        the probability of leaving a state is the sum of its ways out, never one minus the
        probability of staying.
        Each result then has a relative error of a few units in the last place for each state,
        whatever the size of the numbers and however rarely the chain is absorbed.
        Chains that are large, or fill in, go through compiled code, and where elimination would
        fill in through certified iteration; see `MatrixChain`.
        Raises ModelError when `entry` is not a transient state, or when some state is left less
        often than the smallest number of double precision; TooLargeError when an iteration
        cannot be certified.
        """
        check_entry(entry, self.transitions)
        states = tuple(self.transitions)
        index = {state: number for number, state in enumerate(states)}
        ways, slack = split_rows(self.transitions, index)
        solver = solver_of(ways, slack, lambda state: f"'{states[state]}'", "probability")
        totals = [math.fsum(row.values()) for row in self.transitions.values()]
        return ChainSolution(self.transitions, self.absorbing, entry, solver, tuple(totals))

    def transient(self, entry: str, steps: int) -> dict[str, float]:
        """Return the probability of each state after `steps` steps from `entry`.

        Stepping, or repeated squaring where that is less work: sums of products of
        probabilities, nothing is subtracted.
        Raises ModelError when `entry` is not a transient state or `steps` is below zero.
        """
        check_entry(entry, self.transitions)
        if steps < 0:
            raise ModelError(f"{steps} steps; allowed: 0 or more")
        return distribution_after(self.transitions, self.absorbing, entry, steps)


def distinct_names(
    transitions: Mapping[str, Mapping[str, float]], absorbing: Sequence[str]
) -> set[str]:
    """Return the names of all states; raise ModelError when one is a duplicate."""
    known: set[str] = set()
    for name in (*transitions, *absorbing):
        if name in known:
            raise ModelError(f"duplicate state '{name}' in the chain; rename one")
        known.add(name)
    return known


def check_targets(state: str, row: Mapping[str, float], known: set[str], kind: str) -> None:
    """Raise ModelError when a row leads to an unknown state, or with an impossible weight."""
    for target, weight in row.items():
        if target not in known:
            raise ModelError(
                f"state '{state}': '{target}' is not a state of the chain; {one_of(known, target)}"
            )
        if not 0.0 <= weight < math.inf:
            raise ModelError(f"state '{state}': {weight!r} to '{target}' is not a {kind}")


def check_absorbed(
    transitions: Mapping[str, Mapping[str, float]], absorbing: Sequence[str]
) -> None:
    """Raise ModelError, naming the states, when some can never be absorbed."""
    sources: dict[str, list[str]] = {}
    for state, row in transitions.items():
        for target, weight in row.items():
            if weight > 0.0:
                sources.setdefault(target, []).append(state)
    absorbed = reached(absorbing, lambda state: sources.get(state, ()))
    caught = [state for state in transitions if state not in absorbed]
    if caught:
        raise ModelError(
            f"no absorbing state can be reached from {', '.join(caught)}; lead each to one "
            f"({', '.join(absorbing) or 'there is none'})"
        )


def check_entry(entry: str, transitions: Mapping[str, Mapping[str, float]]) -> None:
    """Raise ModelError when `entry` is not a transient state."""
    if entry not in transitions:
        raise ModelError(f"entry '{entry}' is not a transient state; {one_of(transitions, entry)}")


def split_rows(
    transitions: Mapping[str, Mapping[str, float]], index: Mapping[str, int]
) -> tuple[list[dict[int, float]], list[float]]:
    """Return the ways between the states of `index`, and the weight that leaves them all."""
    ways = []
    slack = []
    for state, row in transitions.items():
        ways.append({index[t]: p for t, p in row.items() if t in index and t != state})
        slack.append(math.fsum(p for t, p in row.items() if t not in index))
    return ways, slack


def _check_sum(state: str, row: Mapping[str, float]) -> None:
    total = math.fsum(row.values())
    if abs(total - 1.0) > _ROW_TOLERANCE:
        raise ModelError(f"state '{state}': its transitions sum to {total!r}; they must sum to 1")
