"""The leaves of fault trees: basic events with their failure models, and house events."""

from __future__ import annotations

from tracerisk.common.records import dataclass
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


@dataclass(frozen=True, slots=True)
class BasicEvent:
    """The failure of one unit; `parameter` names the figure that it shares with others.

    Instances of a component, and the states of a chain, share one parameter; an event that is
    given none has a parameter of its own name.
    `model` says where the figure comes from; one without is given it when the tree is solved.
    """

    name: str
    parameter: str = ""
    model: FailureModel | None = None

    def __post_init__(self) -> None:
        if not self.parameter:
            object.__setattr__(self, "parameter", self.name)


@dataclass(frozen=True, slots=True)
class HouseEvent:
    """A condition that is known to hold (`state` true: it happens) or known not to."""

    name: str
    state: bool
