"""What a Bayesian network is given and gives: distributions, tables over parents, joint states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeAlias, TypeVar

if TYPE_CHECKING:
    from tracerisk.prm.trees.events import FailureModel

States: TypeAlias = Mapping[str, str]
"""A state of each of some conditions."""
Entry = TypeVar("Entry")


@dataclass(frozen=True, slots=True)
class Given(Generic[Entry]):
    """A table over the states of one or several parents.

    The keys of `table` are states of the parent, or tuples of one state for each parent.
    """

    parents: str | tuple[str, ...]
    table: Mapping[str | tuple[str, ...], Entry]

    @property
    def names(self) -> tuple[str, ...]:
        """The parents, in the order of the keys."""
        return (self.parents,) if isinstance(self.parents, str) else self.parents

    def rows(self) -> dict[tuple[str, ...], Entry]:
        """Return the entries by the states of the parents."""
        return {
            (states,) if isinstance(states, str) else states: entry
            for states, entry in self.table.items()
        }


Distribution: TypeAlias = Mapping[str, float]
"""The states of a condition, and the probability of each."""
Figure: TypeAlias = "float | FailureModel"
"""What a basic event has in one state of its conditions."""


@dataclass(frozen=True, slots=True)
class Case:
    """A joint state of conditions: its probability, and what it gives to the events.

    `values` are the probabilities of the fault trees' parameters.
    """

    states: States
    probability: float
    values: Mapping[str, float]
