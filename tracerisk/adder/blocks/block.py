"""The risk annotation block as data: what one block says, and who said it."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import Generic, NamedTuple, TypeVar

from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.errors import Location

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Field(Generic[T]):
    """One value of a block.

    `=` is the tool's (`pinned` false), `:=` the user's (`pinned` true).
    `text` is the value as written, with the user's digits; for a pinned value `computed` is
    what the tool would write, as text (`none` where it computes nothing there any more), and
    `reason` what the user wrote after `;`, in single spaces.
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


class Transition(NamedTuple):
    """One `next` line: the function (or `done`) that follows, and how often, as a fraction."""

    target: str
    weight: Fraction


@dataclass(frozen=True, slots=True)
class ComponentEntry:
    """One `@Component` of a block.

    `redundancy` false: each of the quantity is needed; true: one suffices; see `Redundancy`.
    `probability` is that of one unit of the quantity failing during one visit.
    `added` marks `@Component := {`, `omitted` marks `@Component := omit {`: both the user's,
    with the user's `reason`. An omitted component is no part of the function's risk; its
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
    `added` marks a block given by hand (`@Function := {`), with the user's `reason`.
    `digest` is that of the values that the tool wrote (see `block_digest.py`), `None` for a block
    of an earlier version or in the published form. It is no part of what the block says.
    `has_evidence`: the computed values count only failures that ended the mission on the twin.
    """

    name: str
    call_sequence: Field[int]
    next: Field[tuple[Transition, ...]] | None
    components: tuple[ComponentEntry, ...]
    added: bool = False
    location: Location | None = field(default=None, compare=False)
    reason: str | None = None
    digest: str | None = field(default=None, compare=False)
    has_evidence: bool = False
