"""The leaves of fault trees: basic events with their failure models, and house events."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from tracerisk.prm.numbers.probability import Probability

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol
else:
    Protocol = object


class FailureModel(Protocol):
    """What gives a basic event its probability over a mission; see `failure_models`.

    One whose probability is the same for every mission says so: `needs_mission_time = False`.
    """

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability that the event happens within the mission, [h]."""


class Share(Enum):
    """Which share of a component's failures an event and its parameter stand for."""

    WHOLE = ""
    """All failures of a unit."""
    OWN = "own"
    """Those of a unit alone, beside a common cause."""
    COMMON_CAUSE = "common cause"
    """Those that hit all units at once."""
    SPARES = "spares"
    """Those of a whole group with spares in one visit."""


@dataclass(frozen=True, slots=True)
class BasicEvent:
    """The failure of one unit, or of all units of a component at once."""

    name: str
    """Unique in the tree."""
    parameter: str = ""
    """The figure that it shares with others, as instances of a component do; else its own name."""
    model: FailureModel | None = None
    """Where the figure comes from; an event without one is given it when the tree is solved."""
    component: str = ""
    """The component that fails; the parameter's name where none is given."""
    share: Share = Share.WHOLE
    """Which of the component's failures it is."""

    def __post_init__(self) -> None:
        if not self.parameter:
            object.__setattr__(self, "parameter", self.name)
        if not self.component:
            object.__setattr__(self, "component", self.parameter)


@dataclass(frozen=True, slots=True)
class HouseEvent:
    """A condition whose truth is known."""

    name: str
    """Unique in the tree."""
    state: bool
    """Whether the event happens."""
