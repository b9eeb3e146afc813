"""How much of a unit's hazard ends the mission, visit by visit, as evidence shows it.

Each drawn failure stands for the stretch of the unit's time in use (or idle) that is nearest to it,
and decides whether a failure in that stretch ends the mission. The hazard that ends the mission is
the sum over these stretches, so it does not depend on how the run is divided into visits. A visit's
share c is the part of its time near failures that ended the mission.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from tracerisk.adder.quantify.probability import Term
from tracerisk.common.evidence.cells import Cell, Evidence, Stratum
from tracerisk.common.evidence.share_interval import clopper_pearson
from tracerisk.common.hardware.binding import BoundComponent
from tracerisk.common.hardware.model import CONTROL, POWER
from tracerisk.common.hardware.use import STATES, Use
from tracerisk.trace import Trace

LEAST_OF_UNIT = 10
"""With fewer drawn cells than this, a mode of a unit takes its shares from all like units."""

Shares = tuple[float, ...]
"""The share c of each visit of the trace; empty where all of the hazard counts."""


_KINDS = {"stopped_safely": "stopped safely", "stopped_late": "stopped late"}


class CellOutcome(NamedTuple):
    """What followed a drawn failure that ended the mission, or from which it recovered."""

    mode: str
    """How the unit failed."""
    kind: str
    """`stopped safely`, `stopped late`, `unaware`, or `back to FUNCTION`, as blocks say it."""
    shows_in: str
    """The function in which the effect came first; empty for none, or for a way back."""

    @classmethod
    def of(cls, cell: Cell) -> CellOutcome:
        """Return the outcome of a cell; what is not known to be noticed is unaware."""
        if not cell.fails:
            return cls(cell.mode, f"back to {cell.next_function}", "")
        return cls(cell.mode, _KINDS.get(cell.fate or "", "unaware"), cell.shows_in)

    @property
    def is_back(self) -> bool:
        """Whether the mission recovered."""
        return self.kind.startswith("back to ")


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


_END = "done"
"""How blocks call the end of a mission."""


@dataclass(frozen=True)
class EvidenceShares:
    """The evidence of one controller, applied to the visits of its trace.

    A share is that of the hazard that ends the mission, or that leads back to one of `functions`.
    No hazard is lowered for redundant units, for a mode that names no fault, while the campaign is
    incomplete, or where no scenario declares what the mission is.
    """

    evidence: Evidence
    """The evidence, complete or not."""
    only: CellOutcome | None = None
    """The outcome that counts; `None`: each failure that ended the mission."""
    functions: frozenset[str] = frozenset()
    """The functions to which a mission may recover: what leads back to one of them counts beside
    what ended the mission."""

    def among(self, trace: Trace) -> EvidenceShares:
        """Return the evidence with the functions of a trace, by names that only one has.

        The name of the end of a mission is that of no function (`model_names`).
        """
        names = Counter(function.ref.name for function in trace.functions)
        own = frozenset(name for name, count in names.items() if count == 1 and name != _END)
        return self if own == self.functions else replace(self, functions=own)

    @functools.cached_property
    def of_failures(self) -> EvidenceShares:
        """The evidence of which only what ended the mission counts."""
        return replace(self, only=None, functions=frozenset())

    def _ends(self, cell: Cell) -> bool:
        if self.only is None:
            return cell.fails
        return self._is_known(cell) and CellOutcome.of(cell) == self.only

    def _is_known(self, cell: Cell) -> bool:
        """Whether the model can say what followed."""
        return cell.fails or (cell.fate == "recovered" and cell.next_function in self.functions)

    def outcomes(self, bound: BoundComponent, unit: str | None) -> tuple[CellOutcome, ...]:
        """Return the outcomes of the drawn failures that may count for a unit, sorted."""
        names = {*twin_units(bound), *([] if unit is None else [unit])}
        cells = (cell for cell in self.evidence.cells if cell.drawn and cell.unit in names)
        return tuple(sorted({CellOutcome.of(cell) for cell in cells if self._is_known(cell)}))

    @functools.cached_property
    def _shares_in_use(self) -> dict[Stratum, float]:
        return self.evidence.shares()

    def applied(
        self, bound: BoundComponent, unit: str | None, terms: Sequence[Term], uses: Sequence[Use]
    ) -> tuple[Term, ...]:
        """Return the terms of one unit, each with the share of every visit; `unit` as bound."""
        if not self.evidence.counts or bound.component.redundancy.is_redundant:
            return tuple(terms)
        names = twin_units(bound) if unit is None else (unit,)
        if len(names) != 1:
            return tuple(terms)
        return tuple(self._of_term(bound, names[0], term, uses) for term in terms)

    def _of_term(self, bound: BoundComponent, unit: str, term: Term, uses: Sequence[Use]) -> Term:
        """Return a term with the share of every visit."""
        is_idle = term.counts == "standby"
        if term.mode is not None:
            fault = term.mode.tried_as
            return self._of_fault(bound, unit, fault, term, uses) if fault is not None else term
        if bound.component.modes and (is_idle or not bound.component.modes_by_use):
            return self._of_modes(bound, unit, term, uses)
        # Without modes, take the fault that ends the mission most often.
        tried = sorted({cell.mode for cell in self._cells(unit, is_idle)})
        failures = self.of_failures
        of_faults = [failures._of_fault(bound, unit, fault, term, uses) for fault in tried]
        if not of_faults or not all(item.ends for item in of_faults):
            return term
        sizes = [math.fsum(map(item.hazard, uses)) for item in of_faults]
        chosen = tried[sizes.index(max(sizes))]
        return self._of_fault(bound, unit, chosen, term, uses)

    def _of_modes(self, bound: BoundComponent, unit: str, term: Term, uses: Sequence[Use]) -> Term:
        """Return a figure of all modes; one without a fault counts in full."""
        # Of a mode without a fault no outcome is known.
        left, shares, number = 1.0 if self.only is None else 0.0, [0.0] * len(uses), 0
        for mode in bound.component.modes:
            if mode.tried_as is None:
                continue
            of_fault = self._of_fault(bound, unit, mode.tried_as, term, uses)
            if of_fault.ends:
                left -= mode.fraction
                shares = [s + mode.fraction * c for s, c in zip(shares, of_fault.ends, strict=True)]
                number += of_fault.cells[1]
        ends = tuple(min(1.0, max(0.0, left) + share) for share in shares)
        if not number:
            return term
        use = "idle" if term.counts == "standby" else "in use"
        return replace(term, ends=ends, cells=(f"{unit} {use}", number))

    def _cells(self, unit: str, is_idle: bool, fault: str | None = None) -> list[Cell]:
        return [
            cell
            for cell in self.evidence.cells
            if cell.drawn
            and cell.unit == unit
            and cell.is_idle == is_idle
            and fault in (None, cell.mode)
        ]

    def _of_fault(
        self, bound: BoundComponent, unit: str, fault: str, term: Term, uses: Sequence[Use]
    ) -> Term:
        """Return a term with the share of every visit, by the drawn cells of one fault."""
        if self.only is not None or not self.functions:
            return self._counted(bound, unit, fault, term, uses)
        ending = self._counted(bound, unit, fault, term, uses)
        for outcome in self.outcomes(bound, unit) if ending.ends else ():
            if outcome.is_back and outcome.mode == fault:
                only = replace(self, only=outcome)
                back = only._counted(bound, unit, fault, term, uses)
                ends = zip(ending.ends, back.ends, strict=True)
                ending = replace(ending, ends=tuple(min(1.0, sum(pair)) for pair in ends))
        return ending

    def _counted(
        self, bound: BoundComponent, unit: str, fault: str, term: Term, uses: Sequence[Use]
    ) -> Term:
        is_idle = term.counts == "standby"
        cells = self._cells(unit, is_idle, fault)
        if len(cells) < LEAST_OF_UNIT:
            # Few cells of one unit say little: those of its like count together.
            like = [
                cell for name in twin_units(bound) for cell in self._cells(name, is_idle, fault)
            ]
            if not like:
                return term
            ends = (self._pooled(like, term),) * len(uses)
            return replace(term, ends=ends, cells=(f"{fault} {is_idle}", len(like)))
        described = replace(term, cells=(f"{unit} {fault} {is_idle}", len(cells)))
        if is_idle:
            places = [(cell.time_s - cell.active_s, self._ends(cell)) for cell in cells]
            shares = _nearest(places, [use.standby_s or 0.0 for use in uses])
        else:
            named = [STATES.index(s) for s in STATES if term.mode and s in term.mode.when]
            places = [
                (
                    sum(cell.states_s[i] for i in named) if named else cell.active_s,
                    self._ends(cell),
                )
                for cell in cells
            ]
            shares = _nearest(places, [_in_use(use, named) for use in uses])
        stands_for = [_hazard(term, cell) for cell in cells]
        total = sum(stands_for)
        if total <= 0.0 or term.counts == "visits":
            return replace(described, ends=shares)
        ending = sum(s for s, cell in zip(stands_for, cells, strict=True) if self._ends(cell))
        hazards = [term.hazard(use) for use in uses]
        return replace(described, ends=_scaled(shares, hazards, self._kept(cells, ending / total)))

    def _kept(self, cells: Sequence[Cell], share: float) -> float:
        """Scale a stratum's share by the ratio of the share in figures to the share counted."""
        if self.only is not None:
            return share
        counted = sum(1 for cell in cells if cell.fails) / len(cells)
        kept = self._shares_in_use[cells[0].stratum]
        if kept == counted:
            return share
        return min(1.0, share * kept / counted) if counted else kept

    def _pooled(self, cells: Sequence[Cell], term: Term) -> float:
        """Return one share for cells of several units; for few cells, the upper limit."""
        failed = sum(1 for cell in cells if self._ends(cell))
        if len(cells) < LEAST_OF_UNIT and self.only is None:
            return clopper_pearson(failed, len(cells))[1]
        hazards = [_hazard(term, cell) for cell in cells]
        total = sum(hazards)
        if total <= 0.0:
            return failed / len(cells)
        return sum(h for h, cell in zip(hazards, cells, strict=True) if self._ends(cell)) / total


def _hazard(term: Term, cell: Cell) -> float:
    """Return the hazard of the stretch for which a cell stands."""
    if term.counts == "standby":
        return cell.idle_s
    return term.hazard(Use(cell.stretch, is_active=True))


def _scaled(shares: Shares, hazards: Sequence[float], share: float) -> Shares:
    """Return the visits' shares, scaled so that `share` of the whole hazard ends the mission.

    Load and demands are not spread evenly over a visit, so that the sum would depend on how the run
    is divided into visits; `share` is that of the stretches themselves. None exceeds 1.
    """
    wanted = share * sum(hazards)
    free = [index for index, hazard in enumerate(hazards) if hazard > 0.0]
    values = list(shares)
    for _ in range(len(free) + 1):
        fixed = sum(h for i, h in enumerate(hazards) if h > 0.0 and i not in free)
        now = sum(hazards[i] * shares[i] for i in free)
        left = wanted - fixed
        if not free or left <= 0.0:
            break
        if now <= 0.0:
            # None of these visits lies near a failing cell, yet part of their hazard must end the
            # mission: spread it evenly.
            whole = sum(hazards[i] for i in free)
            for i in free:
                values[i] = min(1.0, left / whole)
            break
        factor = left / now
        above = [i for i in free if shares[i] * factor > 1.0]
        for i in free:
            values[i] = min(1.0, shares[i] * factor)
        if not above:
            break
        free = [i for i in free if i not in above]
    if wanted <= 0.0:
        return tuple(0.0 for _ in shares)
    return tuple(values)


def _in_use(use: Use, named: Sequence[int]) -> float:
    exposure = use.exposure
    if exposure is None:
        return 0.0
    states = (exposure.moving_s, exposure.holding_s, exposure.grasping_s)
    return sum(states[i] for i in named) if named else exposure.active_s


def _nearest(cells: Sequence[tuple[float, bool]], lengths: Sequence[float]) -> Shares:
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
            near = min(ordered, key=lambda pair: abs(pair[0] - begin))
            shares.append(1.0 if near[1] else 0.0)
            continue
        failing = sum(
            max(0.0, min(high, end) - max(low, begin)) for low, high, fails in stretches if fails
        )
        shares.append(min(1.0, failing / length))
        begin = end
    return tuple(shares)
