"""Figures along the mission time, and their means over it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from tracerisk.errors import ModelError


@dataclass(frozen=True, slots=True)
class Curve:
    """Figures along the mission time."""

    times_h: tuple[float, ...]
    """Evenly spaced times from zero to the mission time [h], (n + 1,)."""
    figures: Mapping[str, tuple[float, ...]]
    """Probabilities at these times by name, (n + 1,) each."""
    means: Mapping[str, float]
    """Mean over the mission time by name, by the trapezoidal rule: the probability of failure
    on demand of a system that is asked once, at any time."""

    @property
    def sil_bands(self) -> Mapping[str, int | None]:
        """The safety integrity level in whose band each mean lies, `None` in none.

        IEC 61508-1 (2010), table 2, low demand mode: SIL 4 from 1e-5 to below 1e-4, ..., SIL 1
        from 1e-2 to below 1e-1.
        """
        return {name: sil_band(mean) for name, mean in self.means.items()}


def time_curve(
    figures_at: Callable[[float], Mapping[str, float]], mission_time_h: float, steps: int
) -> Curve:
    """Return the figures at `steps` + 1 times from zero to the mission time [h].

    Raises ModelError for fewer than two steps, and what `figures_at` raises.
    """
    if steps < 2:
        raise ModelError(f"{steps} steps; give at least 2")
    times = tuple(mission_time_h * step / steps for step in range(steps + 1))
    rows = [figures_at(time) for time in times]
    figures = {name: tuple(fields[name] for fields in rows) for name in rows[-1]}
    return Curve(times, figures, {name: _mean(values) for name, values in figures.items()})


def sil_band(mean: float) -> int | None:
    """Return the level in whose band for low demand a mean probability lies."""
    for level in (4, 3, 2, 1):
        if 10.0 ** -(level + 1) <= mean < 10.0**-level:
            return level
    return None


def _mean(values: Sequence[float]) -> float:
    """Return the mean over evenly spaced times, the ends with half their weight."""
    inner = math.fsum(values[1:-1])
    return (inner + (values[0] + values[-1]) / 2.0) / (len(values) - 1)
