"""The risk annotation block as data: what one block says, and who said it."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import Generic, TypeVar

from tracerisk.errors import Location
from tracerisk.hardware.model import Detection

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Field(Generic[T]):
    """One value of a block.

    `=` is the tool's (`pinned` false), `:=` a person's (`pinned` true).
    `text` is the value as written, a person's digits kept; for a pinned value `computed` is
    what the tool would write, as text (`none` where it computes nothing there any more), and
    `reason` what the person wrote after `;`, in single spaces.
    An empty `text` is a value left out, which only an omitted component may do.
    Where a value stands is not part of what it says: `location` is not compared.
    """

    value: T
    text: str
    pinned: bool = False
    computed: str | None = None
    reason: str | None = None
    location: Location | None = field(default=None, compare=False)

    @property
    def is_stated(self) -> bool:
        """Whether the block states the value at all."""
        return bool(self.text)


@dataclass(frozen=True, slots=True)
class Transition:
    """One `next` line: the function (or `done`) that follows, and how often, as a fraction."""

    target: str
    weight: Fraction


@dataclass(frozen=True, slots=True)
class Redundancy:
    """How many units of a component must work, and what makes all of them fail at once.

    False of it: each is needed. Else `required` of them must work, one unless stated.
    `common_cause` is the share of a unit's failure probability that hits all units together, the
    beta factor; the rest is each unit's own.
    The units beyond those required may be spares, which fail at `dormancy` times the rate of a
    working unit: 1 of one that runs along (hot), 0 of one that cannot fail before it is needed
    (cold). `switch` is the probability that a spare fails to take over.
    `detected` tells how long a first failure stays hidden: until the next mission starts, or the
    next visit, as the published method has it.
    """

    is_redundant: bool
    required: int = 1
    common_cause: float = 0.0
    dormancy: float = 1.0
    switch: float = 0.0
    detected: Detection = "mission_start"

    @property
    def has_spares(self) -> bool:
        """Whether the group is one of spares that differ from units running along."""
        return self.is_redundant and (self.dormancy < 1.0 or self.switch > 0.0)

    def __bool__(self) -> bool:
        return self.is_redundant


@dataclass(frozen=True, slots=True)
class ComponentEntry:
    """One `@Component` of a block.

    `redundancy` false: each of the quantity is needed; true: one suffices; see `Redundancy`.
    `probability` is that of one unit of the quantity failing during one visit.
    `added` marks `@Component := {`, `omitted` marks `@Component := omit {`: both a person's,
    with the person's `reason`. An omitted component is no part of the function's risk; its
    values may be left out.
    """

    name: str
    probability: Field[float]
    quantity: Field[int]
    redundancy: Field[Redundancy]
    added: bool = False
    omitted: bool = False
    location: Location | None = field(default=None, compare=False)
    reason: str | None = None


@dataclass(frozen=True, slots=True)
class RiskBlock:
    """The risk annotation of one function.

    `next` is one field over all its lines; `None` where a block (the published form) has none.
    `added` marks a block given by hand (`@Function := {`), with the person's `reason`.
    """

    name: str
    call_sequence: Field[int]
    next: Field[tuple[Transition, ...]] | None
    components: tuple[ComponentEntry, ...]
    added: bool = False
    location: Location | None = field(default=None, compare=False)
    reason: str | None = None
