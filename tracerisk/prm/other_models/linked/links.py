"""Expressions that link the elements of a model: a figure of one as the value of another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.expressions import Difference, Expression, Number, Reference


class ElementKey(NamedTuple):
    """What identifies an element of a linked model."""

    kind: str
    """`parameter`, `fault tree` or `Markov chain`."""
    name: str
    """Name of the element, unique within its kind."""

    def __str__(self) -> str:
        return f"{self.kind} '{self.name}'"


PARAMETER, FAULT_TREE, MARKOV_CHAIN = "parameter", "fault tree", "Markov chain"


class Link(Expression):
    """A figure of an element; it has a value only within a linked model."""

    __slots__ = ()

    @property
    def element(self) -> ElementKey:
        """The element whose figure this is."""
        raise NotImplementedError

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Raise ModelError: only a linked model knows the element."""
        raise ModelError(f"a figure of {self.element} has a value only within a linked model")


@dataclass(frozen=True, slots=True)
class TopEvent(Link):
    """The probability of the top event of a fault tree."""

    tree: str
    """Name of the fault tree."""

    @property
    def element(self) -> ElementKey:
        """The fault tree."""
        return ElementKey(FAULT_TREE, self.tree)


@dataclass(frozen=True, slots=True)
class Absorption(Link):
    """The probability that a chain in discrete time ends in one of some states."""

    chain: str
    """Name of the chain."""
    states: tuple[str, ...]
    """Names of absorbing states, at least one."""

    @property
    def element(self) -> ElementKey:
        """The chain."""
        return ElementKey(MARKOV_CHAIN, self.chain)


@dataclass(frozen=True, slots=True)
class Occupancy(Link):
    """The probability that a chain is in one of some states at one time.

    In continuous time this is the unavailability of a repairable part, or the failure of a group
    with spares.
    """

    chain: str
    """Name of the chain."""
    states: tuple[str, ...]
    """Names of states, at least one."""
    time_h: float | None = None
    """Time in continuous time [h]; `None` for the mission time."""
    steps: int | None = None
    """Number of steps in discrete time; `None` in continuous time."""

    @property
    def element(self) -> ElementKey:
        """The chain."""
        return ElementKey(MARKOV_CHAIN, self.chain)


def complement(expression: Expression) -> Expression:
    """Return 1 - expression; of a figure its other half is taken, nothing is subtracted."""
    return Difference((Number(1.0), expression))


def leaf_key(node: Expression) -> ElementKey | None:
    """Return the element that a node refers to; `None` where it refers to none."""
    if isinstance(node, Reference):
        return ElementKey(PARAMETER, node.name)
    return node.element if isinstance(node, Link) else None
