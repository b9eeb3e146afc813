"""The derivation of a function's figures as text, to be checked with a calculator.

Numbers have eight digits, so that what is printed gives what is printed next. The rows of most
tables are units, each summed over the function's visits, for hazards add up; one table more has
the visits, summed over the units.
"""

from __future__ import annotations

import math
import operator
import textwrap
from collections.abc import Sequence

from tracerisk.adder.figures.derivation import (
    ComponentDerivation,
    FunctionDerivation,
    LoadOfUnit,
    TermDerivation,
    TermOfUnit,
    UnitDerivation,
)
from tracerisk.report.explain.words import (
    block_lines,
    counted_line,
    figure_lines,
    group_lines,
    law_lines,
    needed,
    number,
    plural,
)

_WIDTH = 80
_LONGEST_NAME = 20
_IDLE = (
    "0 s: idle in these visits, without motion and with at most 2 % of the torque's limit, and so "
    "not needed (`tracerisk docs theory#activity`)"
)


def render_derivation(derivation: FunctionDerivation) -> str:
    """Return the derivation as text of 80 columns, the same for the same input everywhere."""
    lines = _head(derivation)
    for component in derivation.components:
        lines += ["", *_component(component, derivation)]
    if derivation.by_hand:
        lines += ["", f"{', '.join(derivation.by_hand)}: by hand, nothing is computed"]
    return "".join(f"{name}\n" for line in lines for name in _wrapped(line))


def _wrapped(line: str) -> list[str]:
    if len(line) <= _WIDTH:
        return [line.rstrip()]
    indent = " " * (len(line) - len(line.lstrip()) + 2)
    return textwrap.wrap(line, _WIDTH, subsequent_indent=indent, break_on_hyphens=False)


def _head(derivation: FunctionDerivation) -> list[str]:
    visits = derivation.visits
    known = [visit.duration_s for visit in visits if visit.duration_s is not None]
    lasted = f", {number(math.fsum(known))} s" if len(known) == len(visits) else ""
    seen = plural(len(visits), "visit")
    mission = "" if derivation.times == len(visits) else f" seen, {derivation.times} in a mission"
    has_modes = any(term.mode for one in derivation.components for term in one.terms)
    fraction = "fraction x " if has_modes else ""
    lines = [
        f"{derivation.function} ({derivation.file}): {seen}{mission}{lasted}",
        f"hazard h = rate x {fraction}what counts; hazards add up; p = 1 - exp(-h)",
    ]
    if any(visit.weight != 1 for visit in visits):
        lines.append("comes: how often a mission has a visit; the sum over visits counts it so")
    if derivation.active == "moving":
        lines.append("active = moving: only moving counts where no failure mode says otherwise")
    return lines


def _component(component: ComponentDerivation, derivation: FunctionDerivation) -> list[str]:
    group = component.group
    gate = "" if group.quantity == 1 else f", {needed(component.redundancy)}"
    lines = [f"{component.name}: {plural(group.quantity, 'unit')}{gate}"]
    if component.source is not None:
        lines.append(f"  source: {component.source}")
    names, legend = _names(component.units)
    lines += legend
    if component.load_law is not None:
        lines += law_lines(component.load_law)
        lines += _load_table(component, names)
    before = None
    for term in component.terms:
        if term.figure != before:
            lines += figure_lines(term, component)
        before = term.figure
        lines.append(counted_line(term))
        lines += _term_table(term, component, names)
    if len(component.terms) > 1:
        lines.append("  together")
        rows = [[number(math.fsum(unit.hazards))] for unit in component.units]
        total = [number(group.hazard)]
        several = group.quantity > 1
        lines += aligned_table(
            ["hazard of each" if several else "hazard"], names, rows, total if several else None
        )
    if len(derivation.visits) > 1:
        lines += _visit_table(component, derivation)
    return [*lines, *group_lines(group), *block_lines(component)]


def _names(units: Sequence[UnitDerivation]) -> tuple[list[str], list[str]]:
    """Return a short name of each unit for the tables, and the lines that give the long ones."""
    named = [
        (unit.element or "always active") + (f" (x{unit.count})" if unit.count > 1 else "")
        for unit in units
    ]
    if max(map(len, named)) <= _LONGEST_NAME:
        return named, []
    short = [f"unit {index}" for index in range(1, len(units) + 1)]
    pairs = (f"{name} {long}" for name, long in zip(short, named, strict=True))
    return short, [f"  {', '.join(pairs)}"]


def _load_table(component: ComponentDerivation, names: Sequence[str]) -> list[str]:
    """Return the table of what the load law needs of each unit: the same for all its terms."""
    law = component.load_law
    assert law is not None
    wearing = next((t for t in component.terms if any(_wears(u.load) for u in t.units)), None)
    if wearing is None:
        return []
    rows = []
    for unit in wearing.units:
        load = unit.load
        assert load is not None
        rows.append(
            [
                number(math.fsum(load.wear_s)),
                number(load.mean_load(law.exponent)),
                number(load.reference_speed),
                number(math.fsum(load.wearing_s)),
            ]
        )
    return aligned_table(["wear [s]", "L", "v0", "W [s]"], names, rows, None)


def _wears(load: LoadOfUnit | None) -> bool:
    return load is not None and any(load.travel_s)


def _term_table(
    term: TermDerivation, component: ComponentDerivation, names: Sequence[str]
) -> list[str]:
    amount = {"demands": "times", "visits": "visits"}.get(term.counts, "T [s]")
    ages = term.figure.kind == "weibull"
    is_loaded = any(unit.load is not None for unit in term.units)
    headings = [amount]
    headings += ["counts [s]"] if is_loaded else []
    # The share of what counts that ends the mission, by the failures tried on the twin.
    has_evidence = any(unit.ends for unit in term.units)
    headings += ["c"] if has_evidence else []
    headings += ["U [s]", "rate [1/s]"] if ages else []
    rows = []
    for unit, whole in zip(term.units, component.units, strict=True):
        row = [math.fsum(unit.amounts)]
        row += [math.fsum(unit.counted)] if is_loaded else []
        row += [_ending_share(unit)] if has_evidence else []
        row += [whole.in_use_s, unit.rate] if ages else []
        rows.append([number(value) for value in (*row, math.fsum(unit.hazards))])
    total = None
    if component.group.quantity > 1:
        counts = [unit.count for unit in component.units]
        hazards = [
            count * hazard
            for unit, count in zip(term.units, counts, strict=True)
            for hazard in unit.hazards
        ]
        total = [*[""] * len(headings), number(math.fsum(hazards))]
    hazard = "hazard" if component.group.quantity == 1 else "hazard of each"
    lines = aligned_table([*headings, hazard], names, rows, total)
    if _has_idle(term):
        lines.append(f"    {_IDLE}")
    return lines


def _has_idle(term: TermDerivation) -> bool:
    """Return whether a term counts all time in use, of which a unit of several has none."""
    counts_use = term.counts == "time in use" and term.states is None
    return counts_use and len(term.units) > 1 and any(not any(u.amounts) for u in term.units)


def _ending_share(unit: TermOfUnit) -> float:
    """Return c over the visits: the share of what counts that ends the mission."""
    counted = math.fsum(unit.counted)
    if not unit.ends or counted <= 0.0:
        return 1.0
    return math.fsum(map(operator.mul, unit.counted, unit.ends)) / counted


def _visit_table(component: ComponentDerivation, derivation: FunctionDerivation) -> list[str]:
    renewed = component.group.renewed
    one = component.group.quantity == 1
    headings = ["start [s]", "lasts [s]", "hazard" if one else "hazard of all units"]
    headings += ["group fails"] if renewed else []
    is_weighted = any(visit.weight != 1 for visit in derivation.visits)
    headings = ["comes", *headings] if is_weighted else headings
    rows = []
    for index, visit in enumerate(derivation.visits):
        hazard = math.fsum(unit.count * unit.hazards[index] for unit in component.units)
        lasts = "?" if visit.duration_s is None else number(visit.duration_s)
        row = [number(visit.start_s), lasts, number(hazard)]
        row = [str(visit.weight), *row] if is_weighted else row
        rows.append([*row, number(renewed[index])] if renewed else row)
    names = [f"visit {visit.number}" for visit in derivation.visits]
    total = [*[""] * (2 + is_weighted), number(component.group.hazard), *[""] * bool(renewed)]
    lines = aligned_table(headings, names, rows, total)
    first = derivation.visits[0]
    if first.number == 1 and first.start_s > 0.0 and first.duration_s is not None:
        lines.append("    start: the first command; visit 1 also lasts for the time before its own")
    return lines


def aligned_table(
    headings: Sequence[str],
    names: Sequence[str],
    rows: Sequence[Sequence[str]],
    total: Sequence[str] | None,
) -> list[str]:
    """Return the lines of a table: a name and right-aligned cells in each, the total last."""
    body = [["", *headings]]
    body += [[name, *row] for name, row in zip(names, rows, strict=True)]
    body += [["sum", *total]] if total is not None else []
    widths = [max(len(row[column]) for row in body) for column in range(len(headings) + 1)]
    return [
        "    "
        + row[0].ljust(widths[0])
        + "".join(f"  {cell.rjust(width)}" for cell, width in zip(row[1:], widths[1:], strict=True))
        for row in body
    ]
