"""The one unit probability that a block holds for units that differ, over several visits.

Own derivation: docs/theory.md#groups. The value is chosen so that like units at that value give the
same group failures over the visits as the unlike units do.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from decimal import Decimal

from tracerisk.adder.quantify.function_use import FunctionUse, Visits, mean_probability
from tracerisk.adder.quantify.group_gates import like_visit, needs_all, stays_hidden, unlike_visit
from tracerisk.adder.quantify.hidden_groups import hidden_values
from tracerisk.adder.quantify.outcome import ZERO, after, solve_hazard, with_digits
from tracerisk.adder.quantify.probability import survival_log
from tracerisk.adder.quantify.repaired_groups import EACH_MISSION, Renewal
from tracerisk.common.hardware.redundancy import Redundancy


@with_digits
def group_unit_probabilities(
    functions: Sequence[FunctionUse], redundancy: Redundancy, renewal: Renewal = EACH_MISSION
) -> tuple[float, ...]:
    """Return for each function the one unit probability that stands for unequal units there.

    A group that is whole again at each visit, or needs every unit, fails over the visits of each
    function as its units do. A group whose failures stay hidden is matched over the whole mission,
    and the functions share its hazard by what each contributes: a failure hidden in one is there in
    the next, so that no function has a figure of its own. They may be found only after several
    missions, or repaired while others go on: then the values give the mean mission.
    Units that are alike in all visits give back their probability.
    Raises HardwareError where spares that differ, or units under repair, are too many to follow.
    """
    quantity = len(functions[0].visits[0])
    is_kept = renewal != EACH_MISSION and stays_hidden(redundancy, quantity)
    if not is_kept and all(
        len(set(units)) == 1 for function in functions for units in function.visits
    ):
        alone = [_of_one_unit(function, redundancy) for function in functions]
        unit_probabilities = [value for value in alone if value is not None]
        if len(unit_probabilities) == len(alone):
            return tuple(unit_probabilities)
    if quantity == 1 or (needs_all(redundancy, quantity) and not redundancy.common_cause):
        return tuple(mean_probability(function.visits) for function in functions)
    if stays_hidden(redundancy, quantity):
        return hidden_values(functions, redundancy, quantity, renewal)
    return tuple(_renewed(function.visits, redundancy, quantity) for function in functions)


def _of_one_unit(each: FunctionUse, redundancy: Redundancy) -> float | None:
    """Return the probability of like units in one function, where no gate is needed for it."""
    values = {units[0] for units in each.visits}
    if len(values) == 1:
        return values.pop()
    plain = not redundancy.is_redundant or (
        redundancy.detected == "mission_start" and not redundancy.common_cause
    )
    return mean_probability(each.visits) if plain else None


def _renewed(visits: Visits, redundancy: Redundancy, quantity: int) -> float:
    """Return the value for groups that are whole again at each visit."""
    # Visits of a cycle come again and again.
    alike = Counter(map(tuple, visits))
    hazards = (unlike_visit(units, redundancy).hazard * times for units, times in alike.items())
    target = sum(hazards, ZERO) / len(visits)
    if target == ZERO:
        return 0.0
    if target.is_infinite():
        return 1.0
    hazard = solve_hazard(
        lambda x: like_visit(after(x), redundancy, quantity).hazard, target, _start(visits)
    )
    return float(after(hazard).p)


def _start(visits: Visits) -> Decimal:
    """Return a hazard near that of like units: the mean over visits and units."""
    hazards = [-survival_log(p) for units in visits for p in units]
    return min(max(Decimal(math.fsum(hazards)) / len(hazards), Decimal("1e-400")), Decimal(30))
