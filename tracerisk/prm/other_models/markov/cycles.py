"""One cycle of a chain that comes back to its entry, and the k-th of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tracerisk.errors import ModelError


@dataclass(frozen=True, slots=True)
class CycleFigures:
    """How one cycle ends; the three probabilities sum to 1."""

    failure: float
    """Probability that the cycle ends in failure."""
    end: float
    """Probability that the cycle ends in another absorbing state."""
    back: float
    """Probability that the chain comes back to its entry."""

    def begun(self, number: int) -> float:
        """Return the probability that cycle `number` is begun; the first one has number 1.

        Raises ModelError when the number is below 1.
        """
        return self._survived(_counted(number) - 1)

    def failure_in(self, number: int) -> float:
        """Return the probability that the chain fails in cycle `number`.

        Raises ModelError when the number is below 1.
        """
        return self.begun(number) * self.failure

    def failure_within(self, number: int) -> float:
        """Return the probability that the chain fails in one of the first `number` cycles.

        Raises ModelError when the number is below 1.
        """
        leaving = self.failure + self.end
        log_back = self._log_back()
        ended = 1.0 if log_back == -math.inf else -math.expm1(_counted(number) * log_back)
        return ended * (self.failure / leaving)

    def _survived(self, count: int) -> float:
        return 1.0 if count == 0 else math.exp(count * self._log_back())

    def _log_back(self) -> float:
        """Return log(back) from the more precise of `back` and what leaves the cycle."""
        leaving = self.failure + self.end
        if leaving < 0.5:
            return math.log1p(-leaving)
        return math.log(self.back) if self.back > 0.0 else -math.inf


def _counted(number: int) -> int:
    if number < 1:
        raise ModelError(f"cycle {number}; cycles are numbered from 1")
    return number
