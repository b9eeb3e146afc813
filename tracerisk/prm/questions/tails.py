"""Intervals of percentiles whatever the distribution, and means that lie in the tails."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.special import special
from tracerisk.prm.numbers.strata import LatinHypercube

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Samples
    from tracerisk.prm.questions.draws import UncertainInput

_CONFIDENCE = 0.95
_PLAIN = 0.5
"""The share of draws that are taken as they come: no weight is above its inverse."""
_SHIFTS = (2.0, 4.0)
"""By how many standard deviations the others are shifted, in one input each."""
_MOST_SHIFTED = 8
"""How many inputs are shifted."""

Interval = tuple[float | None, float | None]


def intervals(results: Samples, percentiles: Sequence[float]) -> tuple[Interval, ...]:
    """Return the interval that holds each percentile with at least 95 %, by order statistics.

    Of n independent draws, how many are below the percentile is binomial; `None` where there are
    too few.
    """
    ordered, count = np.sort(results), len(results)
    ranks = np.arange(count)
    rows = []
    for level in percentiles:
        below = special().bdtr(ranks, count, level / 100.0)
        # P(at most i draws are below): the draw of rank i + 1 from below, and that from above.
        low = int(np.searchsorted(below, (1.0 - _CONFIDENCE) / 2.0, side="right"))
        high = int(np.searchsorted(below, (1.0 + _CONFIDENCE) / 2.0))
        rows.append(
            (
                float(ordered[low - 1]) if low > 0 else None,
                float(ordered[high]) if high < count else None,
            )
        )
    return tuple(rows)


class TailMean(NamedTuple):
    """A mean estimated with draws from the tails."""

    mean: float
    """Estimated mean of the figure."""
    standard_error: float
    """Standard error of `mean`, in the same unit."""
    greatest_share: float
    """Share of `mean` that the greatest draw alone adds, in [0, 1]."""


def tail_mean(
    figure: Callable[[Mapping[str, Samples]], Samples],
    inputs: Mapping[str, UncertainInput],
    leading: Sequence[str],
    samples: int,
    seed: int,
) -> TailMean:
    """Return the mean of a figure by draws of which half come from the tails of leading inputs.

    Each input is drawn by its normal score; in the other half that of one of the first `leading`
    is shifted upwards. The weights make the mean unbiased, and none is above 2, so that the mean
    square is at most twice that of plain draws (defensive mixture: Hesterberg, Technometrics 37
    (1995)).
    """
    shifted = [(name, by) for name in leading[:_MOST_SHIFTED] for by in _SHIFTS]
    plain = samples - int((1.0 - _PLAIN) * samples)
    ends = [plain + (samples - plain) * i // len(shifted) for i in range(len(shifted) + 1)]
    draws = LatinHypercube(samples, seed)
    scores = {name: special().ndtri(draws.uniform(f"tail:{name}:0")) for name in inputs}
    for (name, by), start, end in zip(shifted, ends, ends[1:], strict=False):
        scores[name][start:end] += by
    density = np.full(samples, plain / samples)
    for (name, by), start, end in zip(shifted, ends, ends[1:], strict=False):
        density += (end - start) / samples * np.exp(by * scores[name] - by * by / 2.0)
    most = 1.0 - np.finfo(np.float64).epsneg
    values = {}
    for name, uncertain_input in inputs.items():
        values[name], _ = uncertain_input.values(np.minimum(special().ndtr(scores[name]), most))
    result = figure(values) / density
    total, scale = float(result.sum()), float(result.max()) or 1.0
    error = float((result / scale).std(ddof=1)) * scale / math.sqrt(samples)
    return TailMean(total / samples, error, float(result.max()) / total if total > 0.0 else 0.0)
