"""The elements of a linked model as data: parameters, fault trees, Markov chains, figures."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.distributions import Distribution
from tracerisk.prm.numbers.quantities import is_number
from tracerisk.prm.other_models.expressions import Expression
from tracerisk.prm.other_models.linked.links import FAULT_TREE, MARKOV_CHAIN, PARAMETER, ElementKey
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate

TimeKind = Literal["discrete", "continuous"]

UNITS = (
    "unitless",
    "bool",
    "int",
    "float",
    "hours",
    "hour-1",
    "years",
    "year-1",
    "fit",
    "demands",
)
"""The units of the OpenPRA engine's JSON; they are kept, and convert nothing."""


@dataclass(frozen=True, slots=True)
class ModelParameter:
    """A named figure.

    Raises ModelError when the unit is none of `UNITS`.
    """

    name: str
    """Unique among the parameters of the model."""
    value: Expression
    """Expression of its value; a deviate also gives its distribution."""
    unit: str = ""
    """One of `UNITS`; "" for a probability or another plain number."""
    distribution: Distribution | None = None
    """Distribution of the value; `None` where only `value` may give one."""

    def __post_init__(self) -> None:
        if self.unit and self.unit not in UNITS:
            raise ModelError(f"{self.key}: unit '{self.unit}'; {one_of(UNITS, self.unit)}")

    @property
    def key(self) -> ElementKey:
        """What names it in its model."""
        return ElementKey(PARAMETER, self.name)


@dataclass(frozen=True, slots=True)
class LinkedEvent:
    """A basic event of a linked tree."""

    name: str
    """Events of one name in joined trees are one event."""
    value: Expression
    """Expression of its probability."""


@dataclass(frozen=True, slots=True)
class Transfer:
    """An input of a tree's gates that stands for the top of another tree.

    Both are one tree when they are solved: events of one name in both are one event.
    """

    name: str
    """Name by which the gates refer to it."""
    tree: str
    """Name of the other tree."""


@dataclass(frozen=True, slots=True)
class LinkedTree:
    """A fault tree whose events take their probabilities from expressions."""

    name: str
    """Unique among the fault trees of the model."""
    top: str
    """Name of the gate, event or transfer that is the top event."""
    gates: tuple[Gate, ...] = ()
    """Gates of the tree."""
    events: tuple[LinkedEvent, ...] = ()
    """Basic events of the tree."""
    houses: tuple[HouseEvent, ...] = ()
    """House events of the tree."""
    transfers: tuple[Transfer, ...] = ()
    """Inputs that stand for the tops of other trees."""

    @classmethod
    def of(cls, name: str, tree: FaultTree, values: Iterable[tuple[str, Expression]]) -> LinkedTree:
        """Return a fault tree with a value for each event, by the name of its parameter."""
        by_parameter = dict(values)
        events = tuple(
            LinkedEvent(event.name, by_parameter[event.parameter]) for event in tree.events
        )
        return cls(name, tree.top, tree.gates, events, tree.houses)

    @property
    def key(self) -> ElementKey:
        """What names it in its model."""
        return ElementKey(FAULT_TREE, self.name)


@dataclass(frozen=True, slots=True)
class Transition:
    """A way from one state of a chain to another.

    Without a value it takes a share of the remainder: of what the other transitions of its source
    leave of one.
    """

    source: str
    """Name of the state that it leaves."""
    target: str
    """Name of the state that it leads to."""
    value: Expression | None = None
    """Expression of its probability, or of its rate [1/h] in continuous time; `None` for a
    share of the remainder."""
    share: Fraction = Fraction(1)
    """Share of the remainder; the shares of a state sum to 1."""


@dataclass(frozen=True, slots=True)
class LinkedChain:
    """A Markov chain whose transitions are expressions; what no transition leaves is absorbing.

    Raises ModelError, naming the state, when a transition is a duplicate, shares of the remainder
    are negative or do not sum to one, the entry is not a state, or a chain in continuous time has
    a remainder or a transition to its own source.
    """

    name: str
    """Unique among the chains of the model."""
    entry: str
    """Name of the state in which the chain starts."""
    transitions: tuple[Transition, ...]
    """The transitions, each between two states only once."""
    time: TimeKind = "discrete"
    """Whether values are probabilities of steps (`discrete`) or rates (`continuous`)."""

    def __post_init__(self) -> None:
        where = f"{self.key}"
        seen: set[tuple[str, str]] = set()
        shares: dict[str, Fraction] = {}
        for step in self.transitions:
            here = f"{where}, transition '{step.source}' to '{step.target}'"
            if (step.source, step.target) in seen:
                raise ModelError(f"{here}: duplicate transition; add up the two")
            seen.add((step.source, step.target))
            if self.time == "continuous" and (step.value is None or step.source == step.target):
                text = "the remainder" if step.value is None else "its own source"
                raise ModelError(f"{here}: {text} in continuous time; give a rate to another state")
            if step.value is None:
                if step.share < 0:
                    raise ModelError(f"{here}: share {step.share} of the remainder is below zero")
                shares[step.source] = shares.get(step.source, Fraction(0)) + step.share
        for state, total in shares.items():
            if total != 1:
                raise ModelError(
                    f"{where}, state '{state}': the shares of its remainder sum to {total}; "
                    "they must sum to 1"
                )
        if self.entry not in self.states:
            raise ModelError(
                f"{where}: entry '{self.entry}' is not a state; {one_of(self.states, self.entry)}"
            )

    @property
    def key(self) -> ElementKey:
        """What names it in its model."""
        return ElementKey(MARKOV_CHAIN, self.name)

    @property
    def states(self) -> tuple[str, ...]:
        """All states, in the order in which the transitions name them, sources first."""
        sources = [step.source for step in self.transitions]
        return tuple(dict.fromkeys([*sources, *(step.target for step in self.transitions)]))

    @property
    def absorbing(self) -> tuple[str, ...]:
        """The states that no transition leaves."""
        sources = {step.source for step in self.transitions}
        return tuple(state for state in self.states if state not in sources)


@dataclass(frozen=True, slots=True)
class Figure:
    """A result of the model."""

    name: str
    """Unique among the figures of the model."""
    value: Expression
    """Expression over the elements of the model."""


def check_mission_time(mission_time_h: float | None) -> None:
    """Raise ModelError when a mission time is not a positive number of hours."""
    if mission_time_h is None:
        return
    if not (is_number(mission_time_h) and 0.0 < mission_time_h < math.inf):
        raise ModelError(f"mission time {mission_time_h!r}: give a finite number of hours above 0")
