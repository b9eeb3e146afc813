"""The parts of event trees: forks, paths, what a path collects, and where it leads.

The vocabulary is that of the Open-PSA Model Exchange Format 2.0d, its event tree layer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from tracerisk.errors import ModelError

if TYPE_CHECKING:
    from tracerisk.prm.trees.events import FailureModel


@dataclass(frozen=True, slots=True)
class Condition:
    """What a path collects of a fault tree."""

    node: str
    """Name of the gate, basic event or house event."""
    happens: bool = True
    """Whether it happens on the path."""


@dataclass(frozen=True, slots=True)
class Weight:
    """The probability of a path given what stands before it."""

    value: float | FailureModel
    """Probability, or a failure model that gives it for the length of the mission."""
    complement: bool = False
    """Whether the path has the complement of `value`."""


@dataclass(frozen=True, slots=True)
class SetHouse:
    """A house event set in all conditions that the path collects from here on."""

    house: str
    """Name of the house event."""
    state: bool
    """Whether it happens."""


@dataclass(frozen=True, slots=True)
class InState:
    """A test of the state that the path took at a fork."""

    functional_event: str
    """Name of the functional event of the fork."""
    state: str
    """Name of the state that must have been taken."""


@dataclass(frozen=True, slots=True)
class Initiated:
    """A test of what began the course."""

    initiating_event: str
    """Name of the initiating event that must have begun it."""


@dataclass(frozen=True, slots=True)
class When:
    """Instructions that depend on a test."""

    test: InState | Initiated
    """What is tested."""
    then: tuple[Instruction, ...]
    """Instructions followed where the test holds."""
    otherwise: tuple[Instruction, ...] = ()
    """Instructions followed where it does not."""


Instruction: TypeAlias = Condition | Weight | SetHouse | When


@dataclass(frozen=True, slots=True)
class End:
    """The end of a path."""

    sequence: str
    """Name of the sequence of the tree that it ends in."""


@dataclass(frozen=True, slots=True)
class Resume:
    """A path that goes on as a branch that others may share."""

    branch: str
    """Name of the branch of the tree."""


@dataclass(frozen=True, slots=True)
class Link:
    """A path that goes on at the start of another event tree."""

    event_tree: str
    """Name of the other event tree."""


@dataclass(frozen=True, slots=True)
class Path:
    """One way out of a fork."""

    state: str
    """Name of the functional event's state on this path."""
    target: Target
    """Where the path leads."""
    instructions: tuple[Instruction, ...] = ()
    """What the path collects and sets, in order."""


@dataclass(frozen=True, slots=True)
class Fork:
    """The alternatives at one functional event."""

    functional_event: str
    """Name of the functional event."""
    paths: tuple[Path, ...]
    """The alternatives, at least one, with different states."""


Target: TypeAlias = Fork | End | Resume | Link


@dataclass(frozen=True, slots=True)
class Branch:
    """A part of an event tree: what is collected, and where it leads."""

    target: Target
    """Where the branch leads."""
    instructions: tuple[Instruction, ...] = ()
    """What is collected and set before, in order."""
    name: str = ""
    """Name by which paths resume it; "" where none does."""


@dataclass(frozen=True, slots=True)
class EventSequence:
    """A named end of paths."""

    name: str
    """Unique in the event tree."""
    end_state: str = ""
    """Name of the outcome, which several sequences may share; the sequence's own where none is
    given."""
    instructions: tuple[Instruction, ...] = ()
    """What a path collects and sets when it ends here, in order."""

    def __post_init__(self) -> None:
        if not self.end_state:
            object.__setattr__(self, "end_state", self.name)


@dataclass(frozen=True, slots=True)
class InitiatingEvent:
    """What begins the course."""

    name: str
    """Name of the event."""
    value: float = 1.0
    """Probability in [0, 1], or frequency [1/`per`]."""
    per: str = ""
    """Unit of time of a frequency, such as `year`; "" for a probability."""

    def __post_init__(self) -> None:
        greatest = math.inf if self.per else 1.0
        if not (0.0 <= self.value <= greatest and math.isfinite(self.value)):
            what = f"frequency per {self.per}" if self.per else "probability"
            allowed = (
                "finite, 0 or more" if self.per else ("0 to 1, or give its unit of time with 'per'")
            )
            raise ModelError(
                f"initiating event '{self.name}': {what} {self.value!r}; allowed: {allowed}"
            )
