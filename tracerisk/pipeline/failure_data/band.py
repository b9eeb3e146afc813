"""The band in which a mission's figure lies, by the error factors of its hardware description."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.common.dependencies import is_installed
from tracerisk.pipeline.failure_data.figure_spreads import hardware_spreads, load_factor_of
from tracerisk.prm.questions.set_values import groups_of
from tracerisk.prm.questions.uncertainty import propagate

if TYPE_CHECKING:
    from tracerisk.adder.figures.instances import ComponentInstances
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.prm.hybrid.hybrid import HybridModel

SAMPLES = 2_000
"""The number of draws; of 30 seeds, the ends of a band were within 4 % of those of 10^5."""
_LOW, _HIGH = 5.0, 95.0  # [%]
_SEEN = 0.01  # of a figure: samples are no finer


@dataclass(frozen=True, slots=True)
class Band:
    """Where 90 % of the draws of a mission's failure probability lie."""

    low: float
    """The 5th percentile."""
    high: float
    """The 95th percentile."""
    drawn: tuple[str, ...]
    """The components whose figures were drawn."""
    exact: tuple[str, ...]
    """The components of the model whose figures have no error factor, and count as exact."""
    mean: float | None
    """The mean of the draws; `None` where it hangs on the few greatest of them."""
    point: float
    """The figure itself, with every parameter at its point value."""

    @property
    def words(self) -> str:
        """The band as a sentence."""
        verb = "has none and counts" if len(self.exact) == 1 else "have none and count"
        exact = f"; {', '.join(self.exact)} {verb} as exact" if self.exact else ""
        return (
            f"With 90 % probability that figure lies between {self.low:.1e} and {self.high:.1e}, "
            f"by the error factors of {', '.join(self.drawn)} in {SAMPLES:,} samples{exact}. "
            f"{self._mean_words}"
        )

    @property
    def _mean_words(self) -> str:
        if self.mean is None:
            return "Their mean hangs on the few greatest of them, and is not known."
        more = self.mean / self.point - 1.0 if self.point > 0.0 else 0.0
        percent = 100.0 * abs(more)
        shown = f"{percent:.0f}" if percent >= 100.0 else f"{percent:.2g}"
        than = f"{shown} % {'above' if more > 0.0 else 'below'} the figure"
        return f"The mean is {self.mean:.1e}{f', {than}' * (abs(more) >= _SEEN)}."


def band_lacks(hardware: Hardware) -> str:
    """Return what a band is not known for want of, though error factors are; "" for nothing."""
    stated = [component.name for component in hardware.components if component.is_uncertain]
    if not stated or _can_draw():
        return ""
    return (
        f"How far that figure may be off follows from the error factors of {', '.join(stated)}; "
        "`pip install 'tracerisk[large]'` brings what draws samples of them."
    )


def _can_draw() -> bool:
    return is_installed("numpy") and is_installed("scipy")


def figure_band(
    model: HybridModel,
    hardware: Hardware,
    instances: Sequence[ComponentInstances],
    by_hand: Iterable[str],
    *,
    robot: str,
    seed: int,
) -> Band | None:
    """Return the band of a mission's figure; `None` where no error factor is known of it.

    `instances` are those of the run, and components that `by_hand` names were set by users. Also
    `None` without NumPy and SciPy, which draw the samples.
    """
    stated = {component.name for component in hardware.components if component.is_uncertain}
    if not stated or not _can_draw():
        return None
    load_factor = load_factor_of(robot)
    spreads = hardware_spreads(model, hardware, instances, by_hand=by_hand, load_factor=load_factor)
    drawn = tuple(name for name in spreads.figures if name in stated)
    if not drawn:
        return None

    found = propagate(model, samples=SAMPLES, seed=seed, figures=spreads.figures)
    of_level = dict(zip(found.levels, found.percentiles, strict=True))
    exact = tuple(name for name in groups_of(model) if name not in spreads.figures)
    mean = found.mean if found.knows_mean else None
    return Band(of_level[_LOW], of_level[_HIGH], tuple(spreads.figures), exact, mean, found.point)
