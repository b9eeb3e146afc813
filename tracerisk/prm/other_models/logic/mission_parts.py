"""What few files of Open-PSA or OpenPRA hold: common causes, event trees, phases, substitutions.

Only a file that holds one loads them: to make their classes takes a twentieth of a small solve.
"""

from __future__ import annotations

from dataclasses import dataclass

from tracerisk.prm.other_models.expressions import Expression
from tracerisk.prm.other_models.logic.model import NOWHERE, Place

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.other_models.event_trees.event_tree import EventTree
    from tracerisk.prm.other_models.logic.common_cause import CommonCauseLaw


@dataclass(frozen=True, slots=True)
class GroupDefinition:
    """A common cause group whose figures are expressions."""

    name: str
    """Name of the group."""
    law: CommonCauseLaw
    """How a member's probability is shared among the events that hit several."""
    members: tuple[str, ...]
    """Full names of the basic events."""
    distribution: Expression
    """Expression of the probability of one member."""
    factors: tuple[tuple[int, Expression], ...]
    """Factors of the law with their levels, ((level, expression), ...)."""
    place: Place = NOWHERE
    """Where it is defined."""


@dataclass(frozen=True, slots=True)
class EventTreeDefinition:
    """An event tree as a file defines it."""

    tree: EventTree
    """The event tree."""
    place: Place = NOWHERE
    """Where it is defined."""
    notes: tuple[tuple[str, str, Place], ...] = ()
    """Labels and attributes of its parts, ((kind, name, place), ...)."""

    @property
    def name(self) -> str:
        """The event tree's name."""
        return self.tree.name


@dataclass(frozen=True, slots=True)
class Phase:
    """A share of the mission time with states of house events."""

    name: str
    """Name of the phase."""
    fraction: float
    """Share of the mission time, in [0, 1]."""
    houses: tuple[tuple[str, bool], ...] = ()
    """House events set in the phase, ((name, state), ...)."""
    place: Place = NOWHERE
    """Where it is defined."""


@dataclass(frozen=True, slots=True)
class Alignment:
    """The phases of a mission."""

    name: str
    """Name of the alignment."""
    phases: tuple[Phase, ...]
    """The phases in order."""
    place: Place = NOWHERE
    """Where it is defined."""


@dataclass(frozen=True, slots=True)
class Substitution:
    """A rule on what happens together with a hypothesis.

    With `sources` it is a replacement of events in cut sets, which has no exact probability.
    """

    name: str
    """Name of the rule."""
    hypothesis: str
    """Full name of the gate that states when the rule applies."""
    target: str | bool
    """Full name of the event that happens then; `False` where such courses are left out."""
    sources: tuple[str, ...] = ()
    """Full names of the events that `target` replaces; empty for none."""
    type: str = ""
    """Type that the file states for the rule; "" where none."""
    place: Place = NOWHERE
    """Where it is defined."""
