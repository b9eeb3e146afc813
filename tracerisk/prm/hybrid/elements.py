"""What a hybrid model is made of: parameters, and states with what follows them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Literal

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
    """One way on from a state that did not fail."""

    target: str
    """Name of the next state, or `done`."""
    weight: Fraction
    """Probability of this way, exact; the weights of a state sum to 1."""


FateKind = Literal["stopped_safely", "stopped_late", "unaware", "back"]
"""What follows a failure: a stop before any harm, one after it, nothing at all, or another
function, from which the mission goes on as if nothing had failed."""


@dataclass(frozen=True, slots=True)
class Fate:
    """What follows some of a component's failures."""

    kind: FateKind
    """What follows."""
    share: Fraction
    """Share of the component's failures in a visit, exact."""
    target: str = ""
    """For `back` the function that follows; else empty."""
    shows_in: str = ""
    """The later function in which the failure shows; empty where it shows at once."""
    mode: str = ""
    """The failure mode; empty where none is named."""


@dataclass(frozen=True, slots=True)
class FunctionState:
    """One function as a state of the chain."""

    name: str
    """Qualified name of the function, unique in the model."""
    call_sequence: int
    """Rank of the function by first visit, from 1; unique in the model."""
    tree: FaultTree
    """Fault tree of one visit."""
    probabilities: Mapping[str, float]
    """Probability that one unit fails during one visit, by parameter of `tree`."""
    next: tuple[NextStep, ...]
    """Distribution of what follows, given that nothing failed."""
    spares: Mapping[str, Spares] = field(default_factory=dict)
    """Gates of latent units of which some wait as spares, by name; below other gates all work."""
    fates: Mapping[str, tuple[Fate, ...]] = field(default_factory=dict)
    """What follows failures, by parameter; what the shares of one leave of 1 nobody notices, nor
    the failures of a parameter without fates."""
