"""What a hybrid model is made of: parameters, and states with what follows them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING

from tracerisk.prm.trees.events import Share
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.spares import Spares

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Distribution

DONE = "done"
"""The absorbing state of a mission that succeeded."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A component's figure theta, or a share of it, common to all states and instances."""

    name: str
    """Unique in the model."""
    theta: float
    """The greatest of its per-visit probabilities over the states; a state that lists a smaller
    one holds theta times a fixed factor."""
    distribution: Distribution | None = None
    """How far theta may be off, where that is known."""
    component: str = ""
    """The component whose figure it is; its own name where none is given."""
    share: Share = Share.WHOLE
    """Which of the component's failures it counts."""

    def __post_init__(self) -> None:
        if not self.component:
            object.__setattr__(self, "component", self.name)


@dataclass(frozen=True, slots=True)
class NextStep:
    """What follows a state that did not fail: a state or `done`, and how often."""

    target: str
    weight: Fraction


@dataclass(frozen=True, slots=True)
class FunctionState:
    """One function as a state of the chain.

    `probabilities` gives each parameter of the fault tree the probability that one unit fails
    during one visit.
    `next` holds the distribution of what follows, given that nothing failed.
    `spares` names the gates of latent units some of which wait as spares, and says how; the units
    below any other gate all work.
    """

    name: str
    call_sequence: int
    tree: FaultTree
    probabilities: Mapping[str, float]
    next: tuple[NextStep, ...]
    spares: Mapping[str, Spares] = field(default_factory=dict)
