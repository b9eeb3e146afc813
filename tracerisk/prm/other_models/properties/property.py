"""A property of a chain, as it is read."""

from __future__ import annotations

from dataclasses import dataclass, field

from tracerisk.errors import Location
from tracerisk.prm.other_models.formats.prism.expressions import Expression

PATHS = ("F", "G", "U", "W", "X")


@dataclass(frozen=True, slots=True)
class Window:
    """When something is to happen: from `low` to `high`, `None` where it is left open.

    In steps of a dtmc, in units of time of a ctmc; a strict bound is left out itself.
    """

    low: Expression | None = None
    high: Expression | None = None
    strict_low: bool = False
    strict_high: bool = False


@dataclass(frozen=True, slots=True)
class Asked:
    """What stands in the brackets of a property.

    operator: one of `PATHS`, `S` for the long run, `C` and `I` for rewards up to and at a time;
    left and right: what is to hold before and at the end of U and W; right alone for the others.
    """

    operator: str
    right: Expression | None = None
    left: Expression | None = None
    window: Window = Window()


@dataclass(frozen=True, slots=True)
class Filter:
    """Which of the values by state are meant: all those of the states where `states` holds."""

    operator: str
    states: Expression | None


@dataclass(frozen=True, slots=True)
class Property:
    """A question of a chain: `text` as it stands, `name` where it has one.

    kind: `P` a probability, `R` an expected reward, `S` a share of the long run; bound: the sign
    and the number of a limit, `None` where the value is asked for; reward: the name or the place
    of the rewards.
    """

    text: str
    name: str
    location: Location
    kind: str
    asked: Asked
    bound: tuple[str, Expression] | None = None
    reward: str | int | None = None
    filter: Filter | None = None


@dataclass(frozen=True, slots=True)
class PropertyFile:
    """The properties of a text, with the constants, formulas and labels that it declares.

    A constant without a value is to be given from outside.
    """

    properties: tuple[Property, ...]
    constants: dict[str, Expression | None] = field(default_factory=dict)
    formulas: dict[str, Expression] = field(default_factory=dict)
    labels: dict[str, Expression] = field(default_factory=dict)
