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
    """A table over the states of one or several parents."""

    parents: str | tuple[str, ...]
    """Name of the parent condition, or names of several."""
    table: Mapping[str | tuple[str, ...], Entry]
    """Entry for each state of the parent, or for each tuple of one state for each parent."""

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
    """A joint state of conditions, and what it gives to the events."""

    states: States
    """State of each condition."""
    probability: float
    """Probability of the joint state, given the evidence."""
    values: Mapping[str, float]
    """Probability of each fault-tree parameter in this state."""
