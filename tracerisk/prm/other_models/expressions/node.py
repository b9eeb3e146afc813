"""The base of all expressions, and those without arguments."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.probability import Probability

TYPE_CHECKING = False
if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


class Expression:
    """A node of an expression; a new kind derives from this and says what its value is."""

    __slots__ = ()

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The expressions that this one is computed from."""
        return ()

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:
        """Return the point value, given those of the arguments and the mission time, [h].

        Raises ModelError when the node has no value there.
        """
        raise NotImplementedError

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the values for `size` draws, given those of the arguments: (size,) each.

        Raises ModelError when the node has no value for one of the draws.
        """
        columns = [column.tolist() for column in arguments]
        return np.array(
            [
                self.value([column[draw] for column in columns], mission_time_h)
                for draw in range(size)
            ]
        )

    def probability(self, arguments: Sequence[float], mission_time_h: float) -> Probability:
        """Return the value and its complement, as a probability.

        Raises ModelError when the value is outside [0, 1].
        """
        return Probability.of(self.value(arguments, mission_time_h))


@dataclass(frozen=True, slots=True)
class Number(Expression):
    """A constant."""

    number: float
    """Its value, finite; 0 or 1 for a `bool`."""
    form: str = "float"
    """How it is written in Open-PSA: `float`, `int` or `bool`."""

    def __post_init__(self) -> None:
        if not math.isfinite(self.number):
            raise ModelError(f"{self.number!r} is not allowed; give a finite number")

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the number."""
        return self.number

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:  # noqa: ARG002
        """Return the number, `size` times."""
        return np.full(size, float(self.number))


@dataclass(frozen=True, slots=True)
class Reference(Expression):
    """The value of a parameter, which the evaluation looks up."""

    name: str
    """Name of the parameter."""


@dataclass(frozen=True, slots=True)
class MissionTime(Expression):
    """The mission time, [h]."""

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the mission time."""
        return mission_time_h

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:  # noqa: ARG002
        """Return the mission time, `size` times."""
        return np.full(size, mission_time_h)
