"""What follows failures that end a mission, or from which it recovers, as evidence shows it.

Each such cell stands for the same stretch of its unit's use as in `evidence_shares`. The share
of an outcome in a function is that of the hazard near cells with this outcome; so what it adds up
to over a mission does not depend on how the run is divided into functions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from tracerisk.adder.blocks.block import NO_FAILURES, Field
from tracerisk.adder.blocks.computed_failures import ShareTexts, failures_of
from tracerisk.adder.blocks.failures import FailureModes
from tracerisk.adder.blocks.values import DONE
from tracerisk.adder.quantify.component_activity import ComponentUse, FunctionVisits, UnitUse
from tracerisk.adder.quantify.evidence_shares import CellOutcome, EvidenceShares
from tracerisk.common.strong_components import reached

ShowsIn = Callable[[str, str], str]
"""Returns the later function in which a failure shows, by both names; empty for at once."""


class FailureOutcomes:
    """What follows the failures of one component, by its evidence: a section for each function."""

    def __init__(self, used: ComponentUse, evidence: EvidenceShares | None) -> None:
        """Take from evidence what it knows of the component's units.

        Nothing is said of redundant units, without evidence that figures take, and where its file
        is of an earlier version.
        """
        self._units: list[_Outcomes] = []
        if evidence is None or not evidence.evidence.counts or not evidence.evidence.has_fates:
            return
        if used.component.redundancy.is_redundant and used.bound.quantity > 1:
            return
        for unit, count in _distinct(used.units):
            plain = replace(unit, terms=tuple(replace(term, ends=()) for term in unit.terms))

            def near(counting: EvidenceShares, plain: UnitUse = plain) -> UnitUse:
                terms = counting.applied(used.bound, plain.element, plain.terms, plain.uses)
                return _with_evidence(replace(plain, terms=terms))

            self._units.append(
                _Outcomes(
                    count,
                    unit,
                    near(evidence.of_failures),
                    {
                        outcome: near(replace(evidence, only=outcome))
                        for outcome in evidence.outcomes(used.bound, unit.element)
                    },
                )
            )

    def in_function(
        self, here: FunctionVisits, name: str, shows_in: ShowsIn
    ) -> Field[FailureModes]:
        """Return what follows the component's failures in one function.

        What is known of no cell is left out of the shares, and is undetected.
        Raises UnknownUseError where the trace does not hold what a figure needs.
        """
        whole = known = ending = 0.0
        found: dict[CellOutcome, float] = {}
        for of_unit in self._units:
            whole += of_unit.count * _hazard(of_unit.all, here)
            known += of_unit.count * _hazard(_with_evidence(of_unit.all), here)
            ending += of_unit.count * _hazard(of_unit.ending, here)
            for outcome, unit in of_unit.by_outcome.items():
                later = "" if outcome.is_back else shows_in(name, outcome.shows_in)
                key = outcome._replace(shows_in=later)
                found[key] = found.get(key, 0.0) + of_unit.count * _hazard(unit, here)
        if not 0.0 < known <= whole < math.inf:
            return NO_FAILURES
        # Cells that ended missions stand for all that does, those that recovered for the rest.
        parts = {False: min(known, ending), True: max(0.0, known - ending)}
        near = {
            is_back: math.fsum(hazard for key, hazard in found.items() if key.is_back == is_back)
            for is_back in parts
        }
        shares: ShareTexts = {}
        for outcome, hazard in sorted(found.items()):
            if hazard > 0.0 and parts[outcome.is_back] > 0.0:
                share = parts[outcome.is_back] / whole * hazard / near[outcome.is_back]
                shares.setdefault(outcome.mode, {})[outcome.kind, outcome.shows_in] = share
        return failures_of(shares) if shares else NO_FAILURES


@dataclass(frozen=True, slots=True)
class _Outcomes:
    """A unit, and what of its hazard lies near which drawn failures."""

    count: int
    """How many units of the component are alike."""
    all: UnitUse
    """The unit with the hazard that counts."""
    ending: UnitUse
    """The same with what ended the mission alone."""
    by_outcome: Mapping[CellOutcome, UnitUse]
    """The same with what each outcome has."""


def _with_evidence(unit: UnitUse) -> UnitUse:
    """Return a unit with those of its terms alone of which cells say something."""
    return replace(unit, terms=tuple(term for term in unit.terms if term.ends))


def _distinct(units: Sequence[UnitUse]) -> list[tuple[UnitUse, int]]:
    """Return the units with how many share each, for those of one element are the same."""
    counts: dict[int, tuple[UnitUse, int]] = {}
    for unit in units:
        counts[id(unit)] = (unit, counts.get(id(unit), (unit, 0))[1] + 1)
    return list(counts.values())


def _hazard(unit: UnitUse, here: FunctionVisits) -> float:
    return math.fsum(
        float(comes) * unit.hazard(visit)
        for visit, comes in zip(here.numbers, here.times, strict=True)
    )


def later_functions(following: Mapping[str, Mapping[str, int]]) -> ShowsIn:
    """Return which function a failure shows in, where each mission comes to it; else empty.

    `following` counts what followed each function. Where a mission may end before, as in its last
    cycle, the failure counts as one that shows at once.
    """

    def shows_in(name: str, later: str) -> str:
        if later == name or later not in following or name not in following:
            return ""
        on = reached(
            list(following[name]),
            lambda function: () if function in (later, DONE) else list(following[function]),
        )
        return "" if DONE in on else later

    return shows_in
