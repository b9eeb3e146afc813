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
    """The text of a file, and where its lines begin."""

    shown: str
    """The name of the file in messages."""
    text: str
    """The whole text."""

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
    """A name of something else."""

    name: Name
    """The qualified name, its segments between `::`."""
    at: int
    """The offset of the name in the text [characters]."""
    steps: tuple[Name, ...] = ()
    """The further names after dots, `a.b.c`."""

    def __str__(self) -> str:
        return ".".join("::".join(name) for name in (self.name, *self.steps))


@dataclass(frozen=True, slots=True)
class Literal:
    """A value that is written out."""

    value: float | str | bool | None
    """The number, text or truth value; `None` for `null`."""
    at: int
    """The offset of the value in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Sequence:
    """Values in round brackets."""

    items: tuple[Expression, ...]
    """The values between the commas."""
    at: int
    """The offset of the opening bracket in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Operation:
    """Operands with the operators between them, in the order of the text.

    Their precedence is applied where the value is wanted.
    """

    operands: tuple[Expression, ...]
    """The operands, (n_operators + 1,)."""
    operators: tuple[str, ...]
    """The operators, such as `*`."""
    at: int
    """The offset of the first operand in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Unary:
    """An operator before an operand."""

    operator: str
    """The operator: `+`, `-`, `~` or `not`."""
    operand: Expression
    """The expression to which it applies."""
    at: int
    """The offset of the operator in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with its unit, `8 [h]`."""

    number: Expression
    """The expression before the bracket."""
    unit: Expression
    """The expression in the bracket."""
    at: int
    """The offset of the number in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Instance:
    """A value of a type given by its parts, `new RiskLevel(probability = 0.1)`."""

    of: Reference
    """The type."""
    arguments: tuple[tuple[str | None, Expression], ...]
    """Name and value of each part; the name is `None` for a part by position."""
    at: int
    """The offset of the expression in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Computed:
    """An expression outside the subset; an error only where its value is wanted."""

    at: int
    """The offset of the expression in the text [characters]."""


Expression: TypeAlias = (
    Literal | Reference | Sequence | Operation | Unary | Quantity | Instance | Computed
)


@dataclass(frozen=True, slots=True)
class Multiplicity:
    """Bounds of a number of units, each a number or a name.

    With one bound both are the same; `[*]` has the lower bound 0.
    """

    lower: int | Reference
    """The least number of units."""
    upper: int | Reference | None
    """The greatest number of units; `None` for an open bound."""
    at: int
    """The offset of the bracket in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Value:
    """What a feature is bound to, or has by default."""

    expression: Expression
    """The expression of the value."""
    is_default: bool
    """Whether the value is a default, which a redefinition may replace."""


@dataclass(frozen=True, slots=True)
class Package:
    """A package, and the top of a file as one without a name."""

    name: str | None
    """The name; `None` for the top of a file."""
    short: str | None
    """The short name in `<>`; `None` for none."""
    members: tuple[Member, ...]
    """The elements directly inside."""
    at: int
    """The offset of the package in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Import:
    """An import of one name, of all names in a namespace, or of all those below it as well."""

    target: Reference
    """The name or namespace that is imported."""
    every: bool
    """Whether all names of the namespace are imported (`::*`)."""
    recursive: bool
    """Whether names of inner namespaces are imported as well (`::**`)."""
    is_private: bool
    """Whether the names are visible within the importing namespace only."""
    at: int
    """The offset of the target in the text [characters]."""
    overrides_private: bool = False
    """Whether private names are imported as well (`import all`)."""


@dataclass(frozen=True, slots=True)
class Alias:
    """Another name of an element."""

    name: str | None
    """The other name; `None` where it has a short name only."""
    short: str | None
    """The short name in `<>`; `None` for none."""
    target: Reference
    """The element that it names."""
    at: int
    """The offset of the alias in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Annotation:
    """A metadata usage: on what encloses it, or about other elements."""

    type: Reference
    """The metadata definition."""
    name: str | None
    """The name of the usage; `None` for none."""
    about: tuple[Reference, ...]
    """The elements after `about`; empty for the enclosing element."""
    members: tuple[Member, ...]
    """The features in its body."""
    at: int
    """The offset of the usage in the text [characters]."""


@dataclass(frozen=True, slots=True)
class Element:
    """A definition or a usage."""

    kind: str
    """The keyword, such as `part`; empty for a usage without one."""
    is_definition: bool
    """Whether it is a definition (`part def`) rather than a usage."""
    name: str | None
    """The name; `None` for none."""
    short: str | None
    """The short name in `<>`; `None` for none."""
    at: int
    """The offset of the name in the text, else of the keyword [characters]."""
    bare: Reference | None = None
    """The reference of a usage that only names another feature; `None` for none."""
    types: tuple[Reference, ...] = ()
    """The definitions after `:`."""
    subsets: tuple[Reference, ...] = ()
    """The features after `:>`."""
    redefines: tuple[Reference, ...] = ()
    """The features after `:>>`."""
    multiplicity: Multiplicity | None = None
    """The number of units in `[]`; `None` where none is written."""
    value: Value | None = None
    """The value that it is bound to; `None` for none."""
    members: tuple[Member, ...] = ()
    """The elements in its body."""
    prefixes: tuple[str, ...] = ()
    """The keywords before its kind, such as `ref`."""
    annotations: tuple[Annotation, ...] = field(default=())
    """The metadata before its kind, `#Name`."""

    @property
    def is_part(self) -> bool:
        """Whether it is a usage of a part or an item."""
        return not self.is_definition and self.kind in ("part", "item")


@dataclass(frozen=True, slots=True)
class Skipped:
    """An element outside the subset."""

    word: str
    """The keyword with which it begins."""
    name: str | None
    """The name; `None` where none is declared."""
    metadata: tuple[Reference, ...]
    """The names of metadata in it."""
    at: int
    """The offset of the element in the text [characters]."""


Member: TypeAlias = Package | Import | Alias | Annotation | Element | Skipped
