"""A property of a chain, as it is read."""

from __future__ import annotations

from dataclasses import dataclass, field

from tracerisk.errors import Location
from tracerisk.prm.other_models.formats.prism.expressions import Expression

PATHS = ("F", "G", "U", "W", "X")


@dataclass(frozen=True, slots=True)
class Window:
    """When something is to happen, in steps of a dtmc, in units of time of a ctmc."""

    low: Expression | None = None
    """First moment; `None` for 0."""
    high: Expression | None = None
    """Last moment; `None` for no end."""
    strict_low: bool = False
    """Whether `low` itself is excluded."""
    strict_high: bool = False
    """Whether `high` itself is excluded."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What stands in the brackets of a property."""

    operator: str
    """One of `PATHS`, `S` for the long run, `C` and `I` for rewards up to and at a time."""
    right: Expression | None = None
    """What is to hold at the end of U and W, or alone for the others; `None` as for C and I."""
    left: Expression | None = None
    """What is to hold before the end of U and W; `None` for the others."""
    window: Window = Window()
    """When it is to happen."""


@dataclass(frozen=True, slots=True)
class Filter:
    """Which of the values by state are meant."""

    operator: str
    """How the values are combined: such as `min`, `max`, `avg`, `sum`, `first`, `state`."""
    states: Expression | None
    """Expression of the states meant; `None` for all."""


@dataclass(frozen=True, slots=True)
class Property:
    """A question of a chain."""

    text: str
    """The property as it is written."""
    name: str
    """Name given to it; "" for none."""
    location: Location
    """Place of the property in its text."""
    kind: str
    """`P` for a probability, `R` for an expected reward, `S` for a share of the long run."""
    asked: Asked
    """What stands in its brackets."""
    bound: tuple[str, Expression] | None = None
    """Comparison sign and number of a limit; `None` where the value is asked for."""
    reward: str | int | None = None
    """Name, or number from 1, of the rewards; `None` for the first ones."""
    filter: Filter | None = None
    """Which states are meant; `None` for the initial ones."""


@dataclass(frozen=True, slots=True)
class PropertyFile:
    """The properties of a text, with what it declares."""

    properties: tuple[Property, ...]
    """The properties in order."""
    constants: dict[str, Expression | None] = field(default_factory=dict)
    """Expressions of constants by name; `None` for one to be given from outside."""
    formulas: dict[str, Expression] = field(default_factory=dict)
    """Expressions of formulas by name."""
    labels: dict[str, Expression] = field(default_factory=dict)
    """Expressions of sets of states by label."""
