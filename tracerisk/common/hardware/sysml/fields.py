"""The values of one metadata, each read as the type that its feature has."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NoReturn

from tracerisk.common.hardware.sysml.annotations import Given, Metadata
from tracerisk.common.hardware.sysml.language.name_resolution import Symbol
from tracerisk.common.hardware.sysml.language.standard_names import ENUMERATIONS, OURS, Standard
from tracerisk.common.hardware.sysml.values import Amount, Built, Context, Meaning
from tracerisk.errors import HardwareError, Location, one_of


@dataclass(frozen=True, slots=True, eq=False)
class Fields:
    """The features of a metadata, or of a value within one."""

    owner: str
    """The name of the metadata or value in messages."""
    _values: Mapping[str, Given]
    """What each feature was given, by name."""
    location: Location
    """The place of the metadata or value in its file."""
    _way: tuple[Symbol, ...]
    """The way from the root to the part for which the values are worked out."""

    @classmethod
    def of(cls, found: Metadata, way: tuple[Symbol, ...]) -> Fields:
        """Return the features of a metadata as they are for the part at the end of `way`."""
        assert found.kind is not None
        return cls(found.kind, found.values(), found.location, way)

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def has_expression(self, key: str) -> bool:
        """Whether a feature was given an expression, and not features of its own."""
        given = self._values.get(key)
        return given is not None and given.expression is not None

    def place(self, key: str) -> Location:
        """Return where a feature's value stands, or the metadata where it has none."""
        given = self._values.get(key)
        return self.location if given is None else given.location

    def fail(self, key: str, message: str) -> NoReturn:
        """Raise HardwareError at a feature's value."""
        raise HardwareError(f"{self.owner}.{key}: {message}", self.place(key))

    def meaning(self, key: str) -> Meaning:
        """Return what a feature was given, worked out."""
        given = self._values.get(key)
        if given is None or given.expression is None:
            raise HardwareError(f"{self.owner} has no '{key}'; give it one", self.place(key))
        return Context(given.scope, self._way).evaluate(given.expression)

    def number(self, key: str, *, minimum: float = 0.0, maximum: float | None = None) -> float:
        """Return the finite number that a feature was given, checked against its bounds."""
        value = self.meaning(key)
        if isinstance(value, Amount):
            self.fail(key, "a number has no unit here; leave the unit out")
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.fail(key, f"expected a number, found {described(value)}")
        return self._bounded(key, value, minimum, maximum)

    def _bounded(self, key: str, value: float, minimum: float, maximum: float | None) -> float:
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            self.fail(key, "is not a finite number")
        if number < minimum or (maximum is not None and number > maximum):
            bounds = f"[{minimum:g}, {'inf' if maximum is None else f'{maximum:g}'}]"
            self.fail(key, f"{number:g} is outside {bounds}")
        return number

    def positive(self, key: str, *, maximum: float | None = None) -> float:
        """Return a number above 0."""
        value = self.number(key, maximum=maximum)
        if value == 0.0:
            self.fail(key, "is 0; give a number above 0")
        return value

    def integer(self, key: str) -> int:
        """Return a whole number from 1 on."""
        value = self.meaning(key)
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            self.fail(key, f"expected a whole number from 1 on, found {described(value)}")
        return value

    def boolean(self, key: str, default: bool) -> bool:
        """Return a truth value."""
        if key not in self:
            return default
        value = self.meaning(key)
        if not isinstance(value, bool):
            self.fail(key, f"expected true or false, found {described(value)}")
        return value

    def text(self, key: str) -> str | None:
        """Return a text, `None` where there is none."""
        if key not in self:
            return None
        value = self.meaning(key)
        if not isinstance(value, str):
            self.fail(key, f"expected a string in double quotes, found {described(value)}")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """Return several texts; empty where there are none."""
        if key not in self:
            return ()
        return self._several(key, "name one, or leave it out", self._name)

    def _name(self, key: str, value: Meaning) -> str:
        if not isinstance(value, str):
            self.fail(key, f"expected names in double quotes, found {described(value)}")
        return value

    def word(self, key: str, enumeration: str) -> str:
        """Return what a word of one of our enumerations stands for."""
        return self._word(key, enumeration, self.meaning(key))

    def words(self, key: str, enumeration: str) -> tuple[str, ...]:
        """Return what several words of an enumeration stand for."""

        def read(key: str, value: Meaning) -> str:
            return self._word(key, enumeration, value)

        return self._several(key, self._allowed(enumeration), read)

    def _several(
        self, key: str, advice: str, read: Callable[[str, Meaning], str]
    ) -> tuple[str, ...]:
        """Return what each of one or more values is, as `read` has it; none comes twice."""
        value = self.meaning(key)
        each_of = value if isinstance(value, tuple) else (value,)
        if not each_of:
            self.fail(key, f"is an empty list; {advice}")
        several: list[str] = []
        for number in each_of:
            word = read(key, number)
            if word in several:
                self.fail(key, f"names '{word}' twice")
            several.append(word)
        return tuple(several)

    def _word(self, key: str, enumeration: str, value: Meaning) -> str:
        words = ENUMERATIONS[enumeration]
        if isinstance(value, Standard) and value.path[:-1] == (OURS, enumeration):
            return words[value.path[-1]]
        allowed = self._allowed(enumeration)
        return self.fail(key, f"expected a {enumeration}, found {described(value)}; {allowed}")

    def _allowed(self, enumeration: str) -> str:
        return one_of(f"{enumeration}::{word}" for word in ENUMERATIONS[enumeration])

    def time_s(self, key: str) -> float:
        """Return a time above 0 [s]."""
        amount = self._time(key, "8 [h]")
        return float(amount.number) * amount.unit.seconds

    def long_time(self, key: str) -> Amount:
        """Return a time above 0 in the unit in which it was given."""
        return self._time(key, "30000 [h]")

    def _time(self, key: str, example: str) -> Amount:
        amount = self._amount(key, 1, f"a time with its unit, such as {example}")
        if self._bounded(key, amount.number, 0.0, None) == 0.0:
            self.fail(key, "is 0; give a time above 0")
        return amount

    def rate(self, key: str) -> Amount:
        """Return a rate with its unit."""
        amount = self._amount(key, -1, "a rate with its unit, such as 5.7e-6 [h^-1] or 570 [FIT]")
        self._bounded(key, amount.number, 0.0, None)
        return amount

    def _amount(self, key: str, power: int, example: str) -> Amount:
        value = self.meaning(key)
        if not isinstance(value, Amount) or value.unit.power != power:
            self.fail(key, f"expected {example}, found {described(value)}")
        return value

    def nested(self, key: str, kind: str, package: str = OURS) -> Fields:
        """Return the features of a value that is made of parts."""
        given = self._values[key]
        if given.expression is None:
            return Fields(f"{self.owner}.{key}", given.nested, given.location, self._way)
        value = self.meaning(key)
        if not isinstance(value, Built) or value.of != Standard((package, kind)):
            self.fail(key, f"expected '{{ ... }}' or new {kind}(...), found {described(value)}")
        values = {
            name: Given(expression, scope, expression.at, {})
            for name, (expression, scope) in value.arguments.items()
        }
        return Fields(f"{self.owner}.{key}", values, given.location, self._way)

    def forbid_unknown(self, allowed: tuple[str, ...]) -> None:
        """Raise HardwareError at a feature that is not among `allowed`."""
        for key in self._values:
            if key not in allowed:
                raise HardwareError(
                    f"{self.owner} has no '{key}'; {one_of(allowed, key)}", self.place(key)
                )


def described(value: Meaning) -> str:
    """Return what a value is, for messages."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return f"the truth value {str(value).lower()}"
    if isinstance(value, int | float):
        return f"the number {value} without a unit"
    if isinstance(value, str):
        return f'the string "{value}"'
    if isinstance(value, Standard):
        return str(value)
    if isinstance(value, Amount):
        return "a number in another unit"
    if isinstance(value, tuple):
        return "several values" if value else "nothing"
    return "a unit" if not isinstance(value, Built) else f"{value.of}(...)"
