"""Sums, products and the functions of Open-PSA's arithmetic, Boolean and conditional operations."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import reduce

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.other_models.expressions.node import Expression

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.other_models.expressions.node import Array


@dataclass(frozen=True, slots=True)
class _Operation(Expression):
    """An operation on one or more terms, from left to right."""

    terms: tuple[Expression, ...]
    """Operands from left to right, at least one."""

    def __post_init__(self) -> None:
        if not self.terms:
            raise ModelError(f"a {type(self).__name__.lower()} needs at least one term")

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The terms."""
        return self.terms


class Sum(_Operation):
    """The sum of the terms, rounded once."""

    __slots__ = ()

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the sum."""
        return _total(arguments, "sum")

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:  # noqa: ARG002
        """Return the sums."""
        return reduce(operator.add, arguments)


class Difference(_Operation):
    """The first term less all others, rounded once."""

    __slots__ = ()

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the difference."""
        return _total((arguments[0], *(-term for term in arguments[1:])), "difference")

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:  # noqa: ARG002
        """Return the differences."""
        return reduce(operator.sub, arguments)


class Product(_Operation):
    """The product of the terms."""

    __slots__ = ()

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the product."""
        return _finite(math.prod(arguments), "product")

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:  # noqa: ARG002
        """Return the products."""
        return reduce(operator.mul, arguments)


class Quotient(_Operation):
    """The first term divided by all others."""

    __slots__ = ()

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the quotient."""
        if not all(arguments[1:]):
            raise ModelError("a quotient divides by zero; give another divisor")
        return _finite(reduce(operator.truediv, arguments), "quotient")

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:  # noqa: ARG002
        """Return the quotients."""
        if not all(divisor.all() for divisor in arguments[1:]):
            raise ModelError("a quotient divides by zero in a draw; give another divisor")
        return reduce(operator.truediv, arguments)


@dataclass(frozen=True, slots=True)
class Negation(Expression):
    """The term with its sign changed."""

    term: Expression
    """Expression whose sign is changed."""

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The term."""
        return (self.term,)

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the term with its sign changed."""
        return -arguments[0]

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:  # noqa: ARG002
        """Return the terms with their signs changed."""
        return -arguments[0]


@dataclass(frozen=True, slots=True)
class Call(Expression):
    """A function of Open-PSA, see `FUNCTIONS`.

    Truth is 1 and falsehood 0, any number but 0 counts as true.
    `switch` takes pairs of a condition and its value, and last the value where none holds.
    """

    function: str
    """Open-PSA name of the function, a key of `FUNCTIONS`."""
    terms: tuple[Expression, ...]
    """Arguments, as many as the function takes."""

    def __post_init__(self) -> None:
        if self.function not in FUNCTIONS:
            raise ModelError(
                f"'{self.function}' is not a function; {one_of(FUNCTIONS, self.function)}"
            )
        _, least, most = FUNCTIONS[self.function]
        count = len(self.terms)
        fits = least <= count and (most is None or count <= most)
        if not fits or (self.function == "switch" and not count % 2):
            raise ModelError(f"{self.function} has {count} terms; allowed: {_arity(self.function)}")

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The terms."""
        return self.terms

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the function's value."""
        try:
            result = FUNCTIONS[self.function][0](*arguments)
        except (ValueError, ZeroDivisionError, OverflowError) as error:
            raise _undefined(self.function, arguments) from error
        if isinstance(result, complex) or not math.isfinite(result):
            raise _undefined(self.function, arguments)
        return float(result)

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the function's values."""
        name = _VECTORISED.get(self.function)
        if name is None:
            return Expression.values(self, arguments, mission_time_h, size)
        function = getattr(np, name)
        with np.errstate(all="ignore"):
            array: Array = (
                function(*arguments) if function.nin == 1 else reduce(function, arguments)
            )
        bad = ~np.isfinite(array)
        if bad.any():
            raise _undefined(self.function, [float(argument[bad][0]) for argument in arguments])
        return array


def _arity(function: str) -> str:
    _, least, most = FUNCTIONS[function]
    if function == "switch":
        return "pairs of a condition and a value, and one more value"
    return f"{least}" if least == most else f"{least} or more"


def _undefined(function: str, arguments: Sequence[float]) -> ModelError:
    shown = ", ".join(map(repr, arguments))
    return ModelError(f"{function}({shown}) has no finite value; give other terms")


def _total(terms: Iterable[float], kind: str) -> float:
    try:
        return _finite(math.fsum(terms), kind)
    except OverflowError:
        return _finite(math.inf, kind)


def _finite(value: float, kind: str) -> float:
    if not math.isfinite(value):
        raise ModelError(f"a {kind} is too large for a number; give smaller terms")
    return value


def _choose(*terms: float) -> float:
    """Return the value behind the first condition that holds, else the last term."""
    for condition, value in zip(terms[:-1:2], terms[1::2], strict=True):
        if condition:
            return value
    return terms[-1]


def _remainder(dividend: float, divisor: float) -> float:
    """Return the remainder of whole numbers with the dividend's sign, as C has it."""
    return math.fmod(math.trunc(dividend), math.trunc(divisor))


FUNCTIONS: dict[str, tuple[Callable[..., float], int, int | None]] = {
    "abs": (abs, 1, 1),
    "acos": (math.acos, 1, 1),
    "asin": (math.asin, 1, 1),
    "atan": (math.atan, 1, 1),
    "ceil": (math.ceil, 1, 1),
    "cos": (math.cos, 1, 1),
    "cosh": (math.cosh, 1, 1),
    "exp": (math.exp, 1, 1),
    "floor": (math.floor, 1, 1),
    "log": (math.log, 1, 1),
    "log10": (math.log10, 1, 1),
    "sin": (math.sin, 1, 1),
    "sinh": (math.sinh, 1, 1),
    "sqrt": (math.sqrt, 1, 1),
    "tan": (math.tan, 1, 1),
    "tanh": (math.tanh, 1, 1),
    "mod": (_remainder, 2, 2),
    "pow": (math.pow, 2, 2),
    "min": (lambda *terms: min(terms), 1, None),
    "max": (lambda *terms: max(terms), 1, None),
    "mean": (lambda *terms: math.fsum(terms) / len(terms), 1, None),
    "pi": (lambda: math.pi, 0, 0),
    "not": (lambda term: not term, 1, 1),
    "and": (lambda *terms: all(terms), 1, None),
    "or": (lambda *terms: any(terms), 1, None),
    "eq": (operator.eq, 2, 2),
    "df": (operator.ne, 2, 2),
    "lt": (operator.lt, 2, 2),
    "gt": (operator.gt, 2, 2),
    "leq": (operator.le, 2, 2),
    "geq": (operator.ge, 2, 2),
    "ite": (lambda test, yes, no: yes if test else no, 3, 3),
    "switch": (_choose, 1, None),
}
"""The functions by name: how each is computed, its least and greatest number of terms."""

_VECTORISED = {
    "abs": "abs",
    "exp": "exp",
    "log": "log",
    "log10": "log10",
    "sqrt": "sqrt",
    "pow": "power",
    "min": "minimum",
    "max": "maximum",
}
