"""What dynamic fault trees have beside the gates of static ones.

Source: J. B. Dugan, S. J. Bavuso, M. A. Boyd, "Dynamic fault-tree models for fault-tolerant
computer systems", IEEE Transactions on Reliability 41 (1992); what is left open there is read as in
S. Junges, D. Guck, J.-P. Katoen, M. Stoelinga, "Uncovering dynamic fault trees", DSN 2016.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.quantities import check_share
from tracerisk.prm.trees.events import FailureModel


class DynamicKind(enum.Enum):
    """How a dynamic gate joins its inputs.

    PAND happens when all inputs do, from the first to the last in their order; POR when the first
    does before any other.
    SPARE happens when the unit in use fails and no other can take over: the first input is in use
    from the start, the others wait, are taken in their order, and may be shared with other spare
    gates; one that failed while it waited, or that another gate has taken, is passed over.
    """

    PAND = "pand"
    POR = "por"
    SPARE = "spare"


class RestrictionKind(enum.Enum):
    """What a restriction rules out; the events that would bring it about cannot happen then.

    SEQUENCE: that an input happens before one that stands before it; EXCLUSION: that two happen.
    """

    SEQUENCE = "seq"
    EXCLUSION = "mutex"


@dataclass(frozen=True, slots=True)
class DynamicEvent:
    """The failure of one unit, which may wait as a spare.

    In the group of a dynamic gate an event needs a constant rate (`Exponential`, `Erlang`), or a
    probability of being failed from the start, waiting or not (`Constant`, `PerDemand`).

    Raises ModelError when the dormancy is outside [0, 1].
    """

    name: str
    """Unique in the tree."""
    model: FailureModel
    """Failure model of the unit in service."""
    dormancy: float = 1.0
    """Failure rate while waiting over the rate in service: 0 for a cold spare, 1 for a hot one."""

    def __post_init__(self) -> None:
        check_share(f"event '{self.name}': dormancy", self.dormancy)


@dataclass(frozen=True, slots=True)
class DynamicGate:
    """A gate for which the order of failures counts.

    Raises ModelError when it has no input or the switch does not fit.
    """

    name: str
    """Unique in the tree."""
    kind: DynamicKind
    """How the inputs are joined."""
    inputs: tuple[str, ...]
    """Names of the gates and events below it, in the order that counts."""
    inclusive: bool = True
    """Whether inputs that fail at the same instant count as in order, of PAND and POR."""
    switch: float = 0.0
    """Probability that a spare fails to take over, which makes a SPARE gate happen."""

    def __post_init__(self) -> None:
        if not self.inputs:
            raise ModelError(f"gate '{self.name}': {self.kind.value} needs at least one input")
        if len(set(self.inputs)) < len(self.inputs):
            raise ModelError(f"gate '{self.name}': duplicate input; name each once")
        check_share(f"gate '{self.name}': switch", self.switch)
        if self.switch and self.kind is not DynamicKind.SPARE:
            raise ModelError(f"gate '{self.name}': switch is for spare gates only; leave it out")
        if not self.inclusive and self.kind is DynamicKind.SPARE:
            raise ModelError(f"gate '{self.name}': inclusive is for pand and por; leave it out")


@dataclass(frozen=True, slots=True)
class Dependency:
    """When the trigger happens, all the dependent events may do too.

    They happen together, just after the trigger. Where several dependencies have the same instant
    they act in the order in which they stand in the tree; one that a restriction rules out waits
    until it may.

    Raises ModelError when there are no dependents, or the probability is not above 0 and at most 1.
    """

    name: str
    """Unique in the tree."""
    trigger: str
    """Name of the gate or event that brings the others about."""
    dependents: tuple[str, ...]
    """Names of the dependent events, at least one."""
    probability: float = 1.0
    """Probability that the trigger brings them about, above 0."""

    def __post_init__(self) -> None:
        if not self.dependents or self.trigger in self.dependents:
            raise ModelError(
                f"dependency '{self.name}': it needs at least one dependent event, and its "
                "trigger cannot be one"
            )
        if not 0.0 < self.probability <= 1.0:
            raise ModelError(
                f"dependency '{self.name}': probability is {self.probability!r}; allowed: above 0, "
                "at most 1"
            )

    @property
    def inputs(self) -> tuple[str, ...]:
        """The trigger and the dependents."""
        return (self.trigger, *self.dependents)


@dataclass(frozen=True, slots=True)
class Restriction:
    """Something that cannot happen, among gates and events.

    Raises ModelError when it has fewer than two inputs.
    """

    name: str
    """Unique in the tree."""
    kind: RestrictionKind
    """What is ruled out."""
    inputs: tuple[str, ...]
    """Names of the gates and events concerned, at least two, in order."""

    def __post_init__(self) -> None:
        if len(set(self.inputs)) < max(len(self.inputs), 2):
            raise ModelError(
                f"restriction '{self.name}': {self.kind.value} needs two inputs or more, each once"
            )
