"""What every element of a linked model offers once its inputs are known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from tracerisk.prm.expressions import Expression
from tracerisk.prm.linked.links import Link
from tracerisk.prm.numbers.probability import Probability


class SolvedElement(Protocol):
    """An element solved for one set of inputs, in the order of its expressions."""

    def figure(self, link: Link) -> Probability:
        """Return the figure that a link asks for, as a pair."""
        ...

    def gradient(self, link: Link) -> Sequence[float]:
        """Return the derivative of the figure by each input."""
        ...

    def change(self, low: Any, changes: Sequence[float], link: Link) -> float:
        """Return the figure less that of `low`; `changes` are those of the inputs, exact."""
        ...


class SolvableElement(Protocol):
    """An element made ready for solving; `inputs` are the expressions that it needs."""

    @property
    def inputs(self) -> tuple[Expression, ...]:
        """The expressions whose values it needs."""
        ...

    def check(self, link: Link) -> None:
        """Raise ModelError when a link asks for what the element has not."""
        ...

    def solve(self, inputs: Sequence[Probability], mission_time_h: float) -> SolvedElement:
        """Return the element solved; raise ModelError when that cannot be done."""
        ...
