"""A chain as files of states and transitions hold it: numbered states, labels, one start."""

from __future__ import annotations

import enum
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import TYPE_CHECKING

from tracerisk.common.dependencies import require_large
from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.other_models.markov import ContinuousChain, MarkovChain

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.large.matrix_chain import MatrixChain

INITIAL = "init"
"""The label of the state in which a chain starts."""
_KEPT = ("init", "deadlock")
_NOT_IN_IDENTIFIERS = re.compile(r"[^A-Za-z0-9_]")


class ChainKind(enum.Enum):
    """What the numbers of a chain are: probabilities of steps, or rates in continuous time."""

    DTMC = "dtmc"
    CTMC = "ctmc"


@dataclass(frozen=True, slots=True)
class Rewards:
    """What each state earns: in one step, or in continuous time per unit of time."""

    states: list[float]
    """Reward for being in each state, (n_states,)."""
    moves: list[float]
    """Expected reward for the moves out of each state, (n_states,)."""


@dataclass(frozen=True, slots=True)
class ExplicitChain:
    """A chain with numbered states, as PRISM and Storm hold it.

    A state is absorbing when its row is empty or leads to nothing but itself.
    """

    kind: ChainKind
    """Whether the chain is in discrete or continuous time."""
    initial: int
    """Number of the state in which the chain starts; the first where there are several."""
    rows: tuple[Mapping[int, float], ...]
    """Probability or rate of going from each state to others, by number of the target,
    (n_states,)."""
    labels: Mapping[str, frozenset[int]]
    """Sets of states, as numbers, by label."""
    names: tuple[str, ...]
    """Name of each state, (n_states,)."""
    notes: tuple[str, ...] = field(default=(), compare=False)
    """What a reader left out or assumed, one sentence each."""
    starts: tuple[int, ...] = ()
    """Numbers of the states in which the chain can begin; empty where `initial` is the only
    one."""
    rewards: Mapping[str, Rewards] = field(default_factory=dict, compare=False)
    """Reward structures by name."""

    @property
    def absorbing(self) -> tuple[int, ...]:
        """The states that are never left, in order."""
        return tuple(state for state, row in enumerate(self.rows) if not _is_left(state, row))

    @property
    def entry(self) -> str:
        """The name of the state in which the chain starts."""
        return self.names[self.initial]

    def labelled(self, label: str) -> tuple[str, ...]:
        """Return the names of the states of a label, in order; ModelError for an unknown one."""
        if label not in self.labels:
            raise ModelError(f"no label '{label}'; {one_of(self.labels, label)}")
        return tuple(self.names[state] for state in sorted(self.labels[label]))

    def markov_chain(self) -> MarkovChain:
        """Return the chain in discrete time, by the names of its states.

        Raises ModelError for a chain in continuous time, and as MarkovChain does.
        """
        if self.kind is not ChainKind.DTMC:
            raise ModelError("a ctmc has rates, not probabilities; use continuous_chain()")
        return MarkovChain(self._named_rows(), self._named(self.absorbing))

    def matrix_chain(self) -> MatrixChain:
        """Return the chain in discrete time, by the numbers of its states: for many of them.

        Raises ModelError as `markov_chain` does.
        """
        require_large("scipy")
        from scipy.sparse import csr_array

        if self.kind is not ChainKind.DTMC:
            raise ModelError("a ctmc has rates, not probabilities; use continuous_chain()")
        counts = np.fromiter(map(len, self.rows), dtype=np.int64, count=len(self.rows))
        ends = np.concatenate((np.zeros(1, np.int64), np.cumsum(counts)))
        targets = np.fromiter(chain.from_iterable(self.rows), np.int32, count=int(ends[-1]))
        weights = chain.from_iterable(row.values() for row in self.rows)
        values = np.fromiter(weights, np.float64, count=int(ends[-1]))
        matrix = csr_array((values, targets, ends), shape=(len(self.rows),) * 2)
        matrix.sort_indices()
        return MarkovChain.from_matrix(matrix, names=self.names)

    def continuous_chain(self) -> ContinuousChain:
        """Return the chain in continuous time, by the names of its states.

        Raises ModelError for a chain in discrete time, and as ContinuousChain does.
        """
        if self.kind is not ChainKind.CTMC:
            raise ModelError("a dtmc has probabilities, not rates; use markov_chain()")
        return ContinuousChain(self._named_rows(), self._named(self.absorbing))

    def _named(self, states: Iterable[int]) -> tuple[str, ...]:
        return tuple(self.names[state] for state in states)

    def _named_rows(self) -> dict[str, dict[str, float]]:
        ends = set(self.absorbing)
        return {
            self.names[state]: {self.names[target]: weight for target, weight in row.items()}
            for state, row in enumerate(self.rows)
            if state not in ends
        }


def explicit_chain(
    chain: MarkovChain | ContinuousChain,
    entry: str,
    labels: Mapping[str, Iterable[str]] | None = None,
) -> ExplicitChain:
    """Return a chain with its states numbered: first the transient ones, then the absorbing.

    Each state has its name as a label, as far as it is an identifier, `entry` also `init`;
    `labels` name sets of states besides.
    Raises ModelError when the entry or a labelled state is unknown, or two labels clash.
    """
    if isinstance(chain, MarkovChain):
        kind, given = ChainKind.DTMC, chain.transitions
    else:
        kind, given = ChainKind.CTMC, chain.rates
    names = (*given, *chain.absorbing)
    index = {name: number for number, name in enumerate(names)}
    if entry not in index:
        raise ModelError(f"the entry '{entry}' is not a state; {one_of(names, entry)}")
    rows: list[dict[int, float]] = [
        dict(sorted((index[target], weight) for target, weight in row.items() if weight > 0.0))
        for row in given.values()
    ]
    rows.extend({} for _ in chain.absorbing)
    sets: dict[str, frozenset[int]] = {INITIAL: frozenset((index[entry],))}
    for label, states in (labels or {}).items():
        if label in sets or label in _KEPT or _NOT_IN_IDENTIFIERS.search(label) or not label:
            raise ModelError(
                f"label '{label}': a label must be unique, of letters, digits and underscores, "
                f"and none of {', '.join(_KEPT)}"
            )
        chosen = list(states)
        for state in chosen:
            if state not in index:
                raise ModelError(f"label '{label}': no state '{state}'; {one_of(names, state)}")
        sets[label] = frozenset(index[state] for state in chosen)
    own = identifiers(names, (*sets, *_KEPT))
    # The states' own labels come first, for a reader names a state by its first one.
    start = sets.pop(INITIAL)
    alone = {own[name]: frozenset((number,)) for name, number in index.items()}
    ordered = {INITIAL: start, **alone, **sets}
    return ExplicitChain(kind, index[entry], tuple(rows), ordered, names)


def identifiers(names: Sequence[str], taken: Iterable[str]) -> dict[str, str]:
    """Return for each name an identifier of its own that is not among `taken`.

    A name that is one keeps it; else other characters become underscores, and a number follows
    where two would be alike.
    """
    used = set(taken)
    texts: dict[str, str] = {}
    plain = [name for name in names if name not in used and _is_identifier(name)]
    for name in plain:
        texts[name] = name
        used.add(name)
    for name in names:
        if name in texts:
            continue
        stem = _NOT_IN_IDENTIFIERS.sub("_", name)
        stem = stem if stem[:1].isalpha() or stem[:1] == "_" else f"s{stem}"
        candidate, number = stem, 2
        while candidate in used:
            candidate, number = f"{stem}_{number}", number + 1
        texts[name] = candidate
        used.add(candidate)
    return texts


def _is_left(state: int, row: Mapping[int, float]) -> bool:
    # A loop: a generator for each of a million states takes a second.
    for target, weight in row.items():  # noqa: SIM110
        if target != state and weight != 0.0:
            return True
    return False


def names_from_labels(
    count: int, labels: Mapping[str, frozenset[int]], others: Sequence[str] | None = None
) -> tuple[str, ...]:
    """Return a name for each state: its first label that no other state has.

    Else that of `others`, or its number.
    """
    names = list(others) if others is not None else [f"s{state}" for state in range(count)]
    given: set[int] = set()
    for label, states in labels.items():
        if label not in _KEPT and len(states) == 1:
            (state,) = states
            if state not in given:
                given.add(state)
                names[state] = label
    if len(set(names)) == count:
        return tuple(names)
    seen: dict[str, int] = {}
    for state, name in enumerate(names):
        other = seen.setdefault(name, state)
        if other != state:
            # A label of the form s12 on another state than 12: numbers distinguish them.
            names[state] = f"{name}_{state}"
    return tuple(names)


def _is_identifier(name: str) -> bool:
    return bool(name) and not name[0].isdigit() and not _NOT_IN_IDENTIFIERS.search(name)
