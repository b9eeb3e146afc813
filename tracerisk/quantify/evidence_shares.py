"""How much of a unit's hazard ends the mission, visit by visit, as evidence shows it.

The share c of an instant is that of the drawn failure nearest to it, in the time that the unit
was in use (or idle): each stands for the stretch around it. So the shares of a visit add up
however visits are cut.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

from tracerisk.evidence import Cell, Evidence
from tracerisk.hardware.binding import BoundComponent
from tracerisk.hardware.model import CONTROL, POWER
from tracerisk.hardware.use import STATES, Use
from tracerisk.quantify.probability import Term

Shares = tuple[float, ...]
"""The share c of each visit of the trace; empty where all of the hazard counts."""


def twin_units(bound: BoundComponent) -> tuple[str, ...]:
    """Return the units of the twin in which a component is seen.

    What is always active is the power supply or the control unit, by its name.
    """
    if not bound.component.always_active:
        return tuple(dict.fromkeys(bound.elements))
    name = bound.component.name.lower()
    if "power" in name or "supply" in name:
        return (POWER,)
    return (CONTROL,) if "control" in name or "computer" in name else ()


@dataclass(frozen=True, slots=True)
class EvidenceShares:
    """The evidence of one controller, applied to the visits of its trace.

    Nothing is lowered of redundant units, of a mode that names no fault, while the campaign is
    not complete, or where no scenario declares what the mission is.
    """

    evidence: Evidence

    @property
    def counts(self) -> bool:
        """Whether figures take the evidence at all."""
        return self.evidence.is_complete and bool(self.evidence.success)

    def applied(
        self, bound: BoundComponent, unit: str | None, terms: Sequence[Term], uses: Sequence[Use]
    ) -> tuple[Term, ...]:
        """Return the terms of one unit, each with the share of every visit; `unit` as bound."""
        if not self.counts or bound.component.redundancy.is_redundant:
            return tuple(terms)
        names = twin_units(bound) if unit is None else (unit,)
        if len(names) != 1:
            return tuple(terms)
        return tuple(
            replace(term, ends=self._of_term(bound, names[0], term, uses)) for term in terms
        )

    def _of_term(self, bound: BoundComponent, unit: str, term: Term, uses: Sequence[Use]) -> Shares:
        is_idle = term.counts == "standby"
        if term.mode is not None:
            fault = term.mode.fault
            return self._of_fault(unit, fault, term, uses) if fault is not None else ()
        modes = bound.component.modes
        if is_idle and modes:
            # What of the hazard is of no mode with a fault counts in full.
            parts = [
                (mode.fraction, self._of_fault(unit, mode.fault, term, uses))
                for mode in modes
                if mode.fault is not None
            ]
            rest = 1.0 - sum(fraction for fraction, shares in parts if shares)
            known = [(fraction, shares) for fraction, shares in parts if shares]
            return tuple(
                min(1.0, max(0.0, rest) + sum(fraction * c[visit] for fraction, c in known))
                for visit in range(len(uses))
            )
        # Without modes the worst of the faults counts, instant by instant.
        tried = sorted({each.mode for each in self._cells(unit, is_idle)})
        found = [self._of_fault(unit, fault, term, uses) for fault in tried]
        return tuple(map(max, zip(*found, strict=True))) if found and all(found) else ()

    def _cells(self, unit: str, is_idle: bool, fault: str | None = None) -> list[Cell]:
        return [
            each
            for each in self.evidence.cells
            if each.drawn
            and each.unit == unit
            and each.is_idle == is_idle
            and fault in (None, each.mode)
        ]

    def _of_fault(self, unit: str, fault: str | None, term: Term, uses: Sequence[Use]) -> Shares:
        is_idle = term.counts == "standby"
        cells = self._cells(unit, is_idle, fault or "")
        if not cells:
            return ()
        if is_idle:
            return _shares(
                [(each.time_s - each.active_s, each.fails) for each in cells],
                [use.standby_s or 0.0 for use in uses],
            )
        named = [STATES.index(s) for s in STATES if term.mode is not None and s in term.mode.when]
        return _shares(
            [
                (sum(each.states_s[i] for i in named) if named else each.active_s, each.fails)
                for each in cells
            ],
            [_in_use(use, named) for use in uses],
        )


def _in_use(use: Use, named: Sequence[int]) -> float:
    exposure = use.exposure
    if exposure is None:
        return 0.0
    states = (exposure.moving_s, exposure.holding_s, exposure.grasping_s)
    return sum(states[i] for i in named) if named else exposure.active_s


def _shares(cells: Sequence[tuple[float, bool]], lengths: Sequence[float]) -> Shares:
    """Return the share of each visit that lies nearest to a failing cell.

    `cells` are positions on the unit's clock with whether the mission failed, `lengths` how far
    the clock goes in each visit [s].
    """
    ordered = sorted(cells)
    places = [place for place, _ in ordered]
    total = sum(lengths)
    # Each cell stands for what is nearer to it than to the next.
    bounds = [0.0, *((a + b) / 2.0 for a, b in itertools.pairwise(places)), total]
    stretches = [
        (min(low, total), min(high, total), fails)
        for (low, high), (_, fails) in zip(itertools.pairwise(bounds), ordered, strict=True)
    ]
    shares, begin = [], 0.0
    for length in lengths:
        end = begin + length
        if length <= 0.0:
            near = min(ordered, key=lambda each: abs(each[0] - begin))
            shares.append(1.0 if near[1] else 0.0)
            continue
        failing = sum(
            max(0.0, min(high, end) - max(low, begin)) for low, high, fails in stretches if fails
        )
        shares.append(min(1.0, failing / length))
        begin = end
    return tuple(shares)
