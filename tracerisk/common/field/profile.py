"""What recorded missions show: how often each function comes, what follows, how long it lasts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from tracerisk.common.evidence.share_interval import beta_quantile, clopper_pearson

CONFIDENCE = 0.9
QUANTITIES = (
    *("active_s", "moving_s", "holding_s", "grasping_s"),
    *("starts", "grasps", "releases"),
)
"""What a unit does in a visit: seconds and counts, as in `Exposure` of the trace."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A mean over missions with its 90 % interval."""

    mean: float
    """The mean, in the unit of the quantity that is estimated."""
    low: float | None = None
    """The lower end of the interval; `None` where a single mission is known."""
    high: float | None = None
    """The upper end of the interval; `None` where a single mission is known."""

    def excludes(self, value: float, *, within: float = 0.0) -> bool:
        """Whether a value lies outside the interval, widened by a share of the mean."""
        if self.low is None or self.high is None:
            return False
        room = within * abs(self.mean)
        return not self.low - room <= value <= self.high + room


@dataclass(frozen=True, slots=True)
class Following:
    """How often a function followed another."""

    count: int
    """The number of visits after which it followed."""
    share: Fraction
    """The fraction of the visits after which it followed, from 0 to 1."""
    low: float
    """The lower end of the share's 90 % interval."""
    high: float
    """The upper end of the share's 90 % interval."""


@dataclass(frozen=True, slots=True)
class FieldStep:
    """One function over all recorded missions."""

    name: str
    """Its name in the model."""
    visits: int
    """How often it was visited in all missions together."""
    per_mission: Estimate
    """Visits per mission."""
    duration_s: Estimate | None
    """The time of a visit [s]; `None` where the recordings do not hold it."""
    uses: Mapping[str, Mapping[str, Estimate]]
    """For each element of the robot what it does in a visit, by `QUANTITIES`."""
    following: Mapping[str, Following]
    """What followed its visits, `done` for the end of the mission."""


@dataclass(frozen=True, slots=True)
class FieldProfile:
    """The operational profile of a controller, as recorded missions show it."""

    controller: str
    """The controller's file."""
    robot: str
    """The name of the robot."""
    missions: int
    """How many missions were recorded."""
    steps: tuple[FieldStep, ...]
    """The functions that were visited, with their visits and successors."""
    totals: Mapping[str, Mapping[str, float]]
    """What each element did in all missions together, by `QUANTITIES`."""
    duration_s: float | None
    """The time of all missions together [s]; `None` where the recordings do not hold it."""

    def shares(self) -> dict[str, dict[str, str]]:
        """Return the operational profile as fractions in words, as `--profile` takes them."""
        return {
            step.name: {
                target: str(following.share) for target, following in step.following.items()
            }
            for step in self.steps
            if step.following
        }


def ratio(amounts: Sequence[float], visits: Sequence[float]) -> Estimate:
    """Return how much there is in a visit, from the sums of several missions.

    The interval is that of a ratio estimator over missions, by Student's t (W. G. Cochran,
    "Sampling Techniques", 3rd ed., 1977, 6.4): visits of one mission are not independent.
    """
    total = math.fsum(visits)
    mean = math.fsum(amounts) / total if total > 0.0 else 0.0
    missions = len(amounts)
    if missions < 2 or total <= 0.0:
        return Estimate(mean)
    rest = math.fsum((y - mean * x) ** 2 for y, x in zip(amounts, visits, strict=True))
    deviation = math.sqrt(missions / (missions - 1) * rest) / total
    reach = student_t(missions - 1, (1.0 + CONFIDENCE) / 2.0) * deviation
    return Estimate(mean, max(0.0, mean - reach), mean + reach)


def following(counts: Mapping[str, int]) -> dict[str, Following]:
    """Return the share of each target with its interval (Clopper and Pearson, 1934)."""
    total = sum(counts.values())
    return {
        target: Following(count, Fraction(count, total), *clopper_pearson(count, total, CONFIDENCE))
        for target, count in counts.items()
    }


def student_t(freedom: int, share: float) -> float:
    """Return the quantile of Student's t distribution, for a share of at least a half."""
    tail = beta_quantile(freedom / 2.0, 0.5, 2.0 * (1.0 - share))
    return math.sqrt(freedom * (1.0 - tail) / tail) if tail > 0.0 else math.inf
