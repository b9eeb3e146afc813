"""The syntax tree of a SysML v2 file; places in it are offsets into its text."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

from tracerisk.errors import Location

Name: TypeAlias = tuple[str, ...]
"""A qualified name, `A::B` as its segments."""


@dataclass(frozen=True)
class SourceText:
    """The text of a file, and where its lines begin; `shown` is its name in messages."""

    shown: str
    text: str

    @cached_property
    def _line_starts(self) -> list[int]:
        starts = [0]
        find = self.text.find
        while (end := find("\n", starts[-1])) >= 0:
            starts.append(end + 1)
        return starts

    def location(self, offset: int) -> Location:
        """Return the place of the character at `offset`."""
        line = bisect_right(self._line_starts, offset)
        return Location(self.shown, line, offset - self._line_starts[line - 1] + 1)


@dataclass(frozen=True, slots=True)
class Reference:
    """A name of something else; `steps` are the further names after dots, `a.b.c`."""

    name: Name
    at: int
    steps: tuple[Name, ...] = ()

    def __str__(self) -> str:
        return ".".join("::".join(name) for name in (self.name, *self.steps))


@dataclass(frozen=True, slots=True)
class Literal:
    """A number, a text, a truth value, or `None` for `null`."""

    value: float | str | bool | None
    at: int


@dataclass(frozen=True, slots=True)
class Sequence:
    """Values in round brackets."""

    items: tuple[Expression, ...]
    at: int


@dataclass(frozen=True, slots=True)
class Operation:
    """Operands with the operators between them, in the order of the text.

    Their precedence is applied where the value is wanted.
    """

    operands: tuple[Expression, ...]
    operators: tuple[str, ...]
    at: int


@dataclass(frozen=True, slots=True)
class Unary:
    """An operator before an operand."""

    operator: str
    operand: Expression
    at: int


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with its unit, `8 [h]`."""

    number: Expression
    unit: Expression
    at: int


@dataclass(frozen=True, slots=True)
class Instance:
    """A value of a type given by its parts, `new RiskLevel(probability = 0.1)`."""

    of: Reference
    arguments: tuple[tuple[str | None, Expression], ...]
    at: int


@dataclass(frozen=True, slots=True)
class Computed:
    """An expression outside the subset; an error only where its value is wanted."""

    at: int


Expression: TypeAlias = (
    Literal | Reference | Sequence | Operation | Unary | Quantity | Instance | Computed
)


@dataclass(frozen=True, slots=True)
class Multiplicity:
    """Bounds of a number of units; `None` for an upper bound that is open.

    Of one bound both are the same; of `[*]` the lower is zero. A bound may be a name.
    """

    lower: int | Reference
    upper: int | Reference | None
    at: int


@dataclass(frozen=True, slots=True)
class Value:
    """What a feature is bound to, or has by default."""

    expression: Expression
    is_default: bool


@dataclass(frozen=True, slots=True)
class Package:
    """A package, and the top of a file as one without a name."""

    name: str | None
    short: str | None
    members: tuple[Member, ...]
    at: int


@dataclass(frozen=True, slots=True)
class Import:
    """An import of one name, of all names in a namespace, or of all those below it as well."""

    target: Reference
    every: bool
    recursive: bool
    is_private: bool
    at: int


@dataclass(frozen=True, slots=True)
class Alias:
    """Another name of an element."""

    name: str | None
    short: str | None
    target: Reference
    at: int


@dataclass(frozen=True, slots=True)
class Annotation:
    """A metadata usage: on what encloses it, or `about` other elements."""

    type: Reference
    name: str | None
    about: tuple[Reference, ...]
    members: tuple[Member, ...]
    at: int


@dataclass(frozen=True, slots=True)
class Element:
    """A definition or a usage; `kind` is its word, empty for a usage that has none."""

    kind: str
    is_definition: bool
    name: str | None
    short: str | None
    at: int
    bare: Reference | None = None
    types: tuple[Reference, ...] = ()
    subsets: tuple[Reference, ...] = ()
    redefines: tuple[Reference, ...] = ()
    multiplicity: Multiplicity | None = None
    value: Value | None = None
    members: tuple[Member, ...] = ()
    prefixes: tuple[str, ...] = ()
    annotations: tuple[Annotation, ...] = field(default=())


@dataclass(frozen=True, slots=True)
class Skipped:
    """An element outside the subset, with the metadata that are named in it."""

    word: str
    metadata: tuple[Reference, ...]
    at: int


Member: TypeAlias = Package | Import | Alias | Annotation | Element | Skipped
