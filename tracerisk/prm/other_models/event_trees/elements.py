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
    """A gate, basic event or house event that happens on a path, or does not."""

    node: str
    happens: bool = True


@dataclass(frozen=True, slots=True)
class Weight:
    """The probability of a path given what stands before it, or the complement of it.

    A failure model gives it for the length of the mission; `ExpressionModel` is one.
    """

    value: float | FailureModel
    complement: bool = False


@dataclass(frozen=True, slots=True)
class SetHouse:
    """A state that a house event has in all conditions that the path collects from here on."""

    house: str
    state: bool


@dataclass(frozen=True, slots=True)
class InState:
    """A test: the path has taken `state` at the fork of a functional event."""

    functional_event: str
    state: str


@dataclass(frozen=True, slots=True)
class Initiated:
    """A test: the course began with this initiating event."""

    initiating_event: str


@dataclass(frozen=True, slots=True)
class When:
    """Instructions that are followed if a test holds, and others if it does not."""

    test: InState | Initiated
    then: tuple[Instruction, ...]
    otherwise: tuple[Instruction, ...] = ()


Instruction: TypeAlias = Condition | Weight | SetHouse | When


@dataclass(frozen=True, slots=True)
class End:
    """The end of a path: a sequence of the tree."""

    sequence: str


@dataclass(frozen=True, slots=True)
class Resume:
    """A path that goes on as a named branch of the tree, which others may share."""

    branch: str


@dataclass(frozen=True, slots=True)
class Link:
    """A path that goes on at the start of another event tree."""

    event_tree: str


@dataclass(frozen=True, slots=True)
class Path:
    """One way out of a fork."""

    state: str
    target: Target
    instructions: tuple[Instruction, ...] = ()


@dataclass(frozen=True, slots=True)
class Fork:
    """The alternatives at one functional event."""

    functional_event: str
    paths: tuple[Path, ...]


Target: TypeAlias = Fork | End | Resume | Link


@dataclass(frozen=True, slots=True)
class Branch:
    """What is collected, and where it leads; `name` where others resume it."""

    target: Target
    instructions: tuple[Instruction, ...] = ()
    name: str = ""


@dataclass(frozen=True, slots=True)
class EventSequence:
    """A named end of paths; several may have one `end_state`, by default each has its own."""

    name: str
    end_state: str = ""
    instructions: tuple[Instruction, ...] = ()

    def __post_init__(self) -> None:
        if not self.end_state:
            object.__setattr__(self, "end_state", self.name)


@dataclass(frozen=True, slots=True)
class InitiatingEvent:
    """What begins the course: a probability, or a frequency `per` unit of time ("year")."""

    name: str
    value: float = 1.0
    per: str = ""

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
