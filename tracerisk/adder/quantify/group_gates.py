"""The gate of a group of units, like or unlike, in one visit at whose start it is whole.

Own derivation: docs/theory.md#groups.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from tracerisk.adder.quantify.outcome import (
    NEVER,
    ONE,
    SURELY,
    ZERO,
    Outcome,
    at_least,
    at_least_of_like,
)
from tracerisk.adder.quantify.spare_units import like_spares, unlike_spares
from tracerisk.common.hardware.redundancy import Redundancy

SURE = Decimal(5000)
"""The hazard of a certain failure where shares of it are needed: it survives once in 1e2171."""


def needs_all(redundancy: Redundancy, quantity: int) -> bool:
    """Return whether a group fails with any of its units."""
    return not redundancy.is_redundant or redundancy.required >= quantity


def stays_hidden(redundancy: Redundancy, quantity: int) -> bool:
    """Return whether the first failures of a group stay hidden until the mission ends."""
    return not needs_all(redundancy, quantity) and redundancy.detected == "mission_start"


def _outcome(p: float) -> Outcome:
    return Outcome(Decimal(p), ONE - Decimal(p)) if p < 1.0 else SURELY


def unlike_visit(
    units: Sequence[float], redundancy: Redundancy, without: int | None = None
) -> Outcome:
    """Return the outcome of one visit of a group that is whole at its start.

    The common cause is computed for a unit with the mean of the units' probabilities, the only mean
    that is additive over visits and units. It belongs to no single unit: with `without`, the others
    share it.
    """
    beta = common_share(redundancy)
    own = [_outcome(p).share(ONE - beta) for p in units]
    if without is not None:
        own[without] = NEVER
    return unlike_apart(own, redundancy).either(_common(units, redundancy, without))


def like_visit(unit: Outcome, redundancy: Redundancy, quantity: int) -> Outcome:
    """Return the same for like units, as the model has it."""
    beta = common_share(redundancy)
    own = unit.share(ONE - beta)
    return like_apart(own, redundancy, quantity).either(unit.share(beta))


def unlike_apart(own: Sequence[Outcome], redundancy: Redundancy) -> Outcome:
    """Return the outcome of a group, whole at first, by its units' own failures (no common cause).

    The hazards of units with spares run in proportion. A unit with a hazard of `SURE` or more is
    taken to fail as soon as it works.
    """
    if not redundancy.has_spares or needs_all(redundancy, len(own)):
        return at_least(threshold_of(redundancy, len(own)), own)
    hazards = [outcome.hazard for outcome in own]
    return unlike_spares([h if h < SURE else Decimal("Infinity") for h in hazards], redundancy)


def like_apart(own: Outcome, redundancy: Redundancy, quantity: int) -> Outcome:
    """Return the same for like units."""
    if not redundancy.has_spares or needs_all(redundancy, quantity):
        return at_least_of_like(threshold_of(redundancy, quantity), quantity, own)
    return like_spares(own.hazard, quantity, redundancy)


def common_share(redundancy: Redundancy) -> Decimal:
    """Return the share of the common cause; 0 if all units are needed."""
    return Decimal(redundancy.common_cause if redundancy.is_redundant else 0.0)


def threshold_of(redundancy: Redundancy, quantity: int) -> int:
    """Return how many failed units fail the group."""
    return 1 if needs_all(redundancy, quantity) else quantity - redundancy.required + 1


def _common(units: Sequence[float], redundancy: Redundancy, without: int | None = None) -> Outcome:
    kept = [p for number, p in enumerate(units) if number != without]
    mean = sum(map(Decimal, kept), ZERO) / len(units)
    return Outcome(mean, ONE - mean).share(common_share(redundancy))
