"""The risk annotation block as data: what one block says, and who said it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Generic, NamedTuple, TypeVar

from tracerisk.adder.blocks.failures import FailureModes
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.config import BlockForm
from tracerisk.errors import Location

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Field(Generic[T]):
    """One value of a block."""

    value: T
    """The value; a default where none is stated."""
    text: str
    """The value as written, with the user's digits; empty for a value left out, which only an
    omitted component may do."""
    pinned: bool = False
    """Whether a user set the value (`:=`); else it is the tool's (`=`)."""
    computed: str | None = None
    """The text that the tool would write for a pinned value: `"none"` if it computes nothing there.
    `None` if the block does not say."""
    reason: str | None = None
    """The user's reason for a pinned value, in single spaces; `None` where not given."""
    location: Location | None = field(default=None, compare=False)
    """The file and line; `None` for a value that is not read from a file. It is not compared."""
    comment_lines: tuple[str, ...] = field(default=(), compare=False)
    """The lines of its comment, as they are typed; empty where it is not read. Not compared."""

    @property
    def is_stated(self) -> bool:
        """Whether the block states the value at all."""
        return bool(self.text)


class Transition(NamedTuple):
    """One `next` line."""

    target: str
    """The function that follows, or `done`."""
    weight: Fraction
    """The fraction of visits after which it follows, from 0 to 1."""


NO_FAILURES: Field[FailureModes] = Field((), "")
"""What stands where nothing is said of what follows failures."""


@dataclass(frozen=True, slots=True)
class ComponentEntry:
    """One `@Component` of a block."""

    name: str
    """The name of the component in the hardware description."""
    probability: Field[float]
    """The probability that one unit of the quantity fails during one visit."""
    quantity: Field[int]
    """The number of units."""
    redundancy: Field[Redundancy]
    """Whether one unit suffices (true) or each is needed (false); see `Redundancy`."""
    added: bool = False
    """Whether a user added the component (`@Component := {`)."""
    omitted: bool = False
    """Whether a user omitted the component (`@Component := omit {`); it is then no part of the
    function's risk, and its values may be left out."""
    location: Location | None = field(default=None, compare=False)
    """The file and line; `None` for a component that is not read from a file."""
    reason: str | None = None
    """The user's reason for adding or omitting it; `None` where not given."""
    reason_lines: tuple[str, ...] = field(default=(), compare=False)
    """The lines of that reason, as they are typed; empty where it is not read. Not compared."""
    failures: Field[FailureModes] = NO_FAILURES
    """What follows its failures, one field over all `mode` lines; left out where nothing is
    said."""


@dataclass(frozen=True, slots=True)
class RiskBlock:
    """The risk annotation of one function."""

    name: str
    """The qualified name of the function."""
    call_sequence: Field[int]
    """The rank of the function in the order of first visits, from 1."""
    next: Field[tuple[Transition, ...]] | None
    """What follows the function, one field over all `next` lines; `None` where the block has none,
    as in the published form."""
    components: tuple[ComponentEntry, ...]
    """The components, in the order of the hardware description."""
    added: bool = False
    """Whether a user gave the block (`@Function := {`)."""
    location: Location | None = field(default=None, compare=False)
    """The file and line; `None` for a block that is not read from a file."""
    reason: str | None = None
    """The user's reason for giving the block; `None` where not given."""
    reason_lines: tuple[str, ...] = field(default=(), compare=False)
    """The lines of that reason, as they are typed; empty where it is not read. Not compared."""
    digest: str | None = field(default=None, compare=False)
    """The digest of the values that the tool wrote (`adder/lock/digest.py`); `None` for a block of
    an earlier version or in the published form. It is not compared."""
    has_evidence: bool = False
    """Whether the computed values count only failures that ended the mission on the twin."""
    form: BlockForm = field(default="published", compare=False)
    """The form in which it is written. It is not compared, for both forms say the same."""
    moved_from: BlockForm | None = field(default=None, compare=False)
    """The form in which it was read, if it is converted: then reasons keep the lines that a user
    gave them. `None` for a block that is written anew. It is not compared."""

    def with_comment_lines(self, change: Callable[[tuple[str, ...]], tuple[str, ...]]) -> RiskBlock:
        """Return the block with the lines of its comments changed."""

        def of_field(value: Field[T]) -> Field[T]:
            return replace(value, comment_lines=change(value.comment_lines))

        return replace(
            self,
            call_sequence=of_field(self.call_sequence),
            next=None if self.next is None else of_field(self.next),
            components=tuple(
                replace(
                    component,
                    probability=of_field(component.probability),
                    quantity=of_field(component.quantity),
                    redundancy=of_field(component.redundancy),
                    failures=of_field(component.failures),
                    reason_lines=change(component.reason_lines),
                )
                for component in self.components
            ),
            reason_lines=change(self.reason_lines),
        )
