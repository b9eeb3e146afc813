"""What touched what during the run, how hard and whether it should, and what was held."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from itertools import groupby

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.traced.elements import Contact, Payload
from tracerisk.report.html import figures
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Section
from tracerisk.report.html.tables import Cell, Column, Row, Table, row_of, texts
from tracerisk.trace import Trace

MOST_UNFOLDED = 12
"""How many rows a table of what is as it should be has before it is folded."""

_Bodies = tuple[FunctionRef, str, str]


def touches_section(report: ReportInput) -> Section | None:
    """Return the contacts and payloads of the run; `None` where none could be seen."""
    trace = report.trace
    if trace is None:
        return None
    is_seen = any(visit.contacts or visit.payloads for visit in trace.visits)
    if not is_seen and all(element.kind != "contact" for element in trace.elements):
        return None
    states = {state.name for state in report.assessment.states}
    by_function = _ByFunction(trace, states)
    html = rendered(
        "touches.html.j2",
        unexpected=_contacts(trace, by_function, expected=False),
        expected=_contacts(trace, by_function, expected=True),
        payloads=_payloads(trace, by_function),
        most=MOST_UNFOLDED,
        is_seen=is_seen,
    )
    return Section("touches", "Contacts and payload", html)


class _ByFunction:
    """Puts the rows of each function under one heading, in the order of the call sequence."""

    def __init__(self, trace: Trace, states: Collection[str]) -> None:
        refs = [function.ref for function in trace.functions]
        self._names = model_names(refs)
        self._order = {ref: index for index, ref in enumerate(refs)}
        self._states = states

    def rows(self, cells: Iterable[tuple[FunctionRef, tuple[Cell | str, ...]]]) -> tuple[Row, ...]:
        ordered = sorted(cells, key=lambda cell: self._order[cell[0]])
        result = []
        for ref, own in groupby(ordered, key=lambda pair: pair[0]):
            name = self._names[ref]
            function = name if name in self._states else None
            several = [rest for _, rest in own]
            for index, rest in enumerate(several):
                head = Cell(name, function=function, rows=0 if index else len(several))
                result.append(row_of(head, *rest, function=function))
        return tuple(result)


def _contacts(trace: Trace, by_function: _ByFunction, *, expected: bool) -> Table | None:
    links = {
        element.part or element.name for element in trace.elements if element.kind == "contact"
    }
    pairs: dict[_Bodies, list[Contact]] = {}
    for visit in trace.visits:
        for contact in visit.contacts:
            if contact.expected == expected:
                pairs.setdefault((visit.function, contact.link, contact.other), []).append(contact)
    if not pairs:
        return None
    columns = (
        *texts("function", "link, or thing held", "other body"),
        Column("greatest force", "N", is_number=True),
        Column("touching", "seconds of the run", is_number=True),
        Column("first at", "seconds", is_number=True),
        Column("visits", "with this touch", is_number=True),
    )
    rows = by_function.rows(
        (
            function,
            (
                Cell(link, note="" if not links or link in links else "held"),
                Cell(other, note="of the arm itself" if other in links else ""),
                _force(touches, other in links),
                figures.seconds(sum(touch.touching_s for touch in touches)),
                figures.seconds(min(touch.start_s for touch in touches)),
                str(_visits(trace, function, touches)),
            ),
        )
        for (function, link, other), touches in pairs.items()
    )
    name, caption = (
        ("contacts", "Expected contacts: what is grasped or held, and where it stands")
        if expected
        else ("unexpected-contacts", "Unexpected contacts")
    )
    return Table(name, caption, columns, rows)


def _visits(trace: Trace, function: FunctionRef, touches: Sequence[Contact]) -> int:
    """Return in how many visits of a function any of the touches was."""
    own = {id(touch) for touch in touches}
    return sum(
        visit.function == function and any(id(contact) in own for contact in visit.contacts)
        for visit in trace.visits
    )


def _force(touches: Sequence[Contact], is_own: bool) -> Cell:
    """Return the greatest force; the arm passes through itself, and feels none."""
    if is_own:
        return Cell(figures.NOTHING, note="not simulated")
    return Cell(_newtons(max(touch.force_n for touch in touches)))


def _payloads(trace: Trace, by_function: _ByFunction) -> Table | None:
    held: dict[_Bodies, list[Payload]] = {}
    for visit in trace.visits:
        for payload in visit.payloads:
            held.setdefault((visit.function, payload.gripper, payload.object), []).append(payload)
    if not held:
        return None
    columns = (
        *texts("function", "gripper", "object"),
        Column("mass", "kg", is_number=True),
        Column("held", "seconds of the run", is_number=True),
        Column("mean pad force", "N, while held", is_number=True),
        Column("greatest pad force", "N", is_number=True),
    )
    rows = by_function.rows(
        (
            function,
            (
                gripper,
                thing,
                f"{payloads[0].mass_kg:.4g}",
                figures.seconds(sum(payload.held_s for payload in payloads)),
                _newtons(_mean_force(payloads)),
                _newtons(max(payload.most_pad_force_n for payload in payloads)),
            ),
        )
        for (function, gripper, thing), payloads in held.items()
    )
    return Table("payloads", "What was held, and how firmly", columns, rows)


def _mean_force(payloads: Sequence[Payload]) -> float:
    """Return the mean over the time in which it was held [N]."""
    held_s = sum(payload.held_s for payload in payloads)
    if not held_s:
        return max(payload.pad_force_n for payload in payloads)
    return sum(payload.pad_force_n * payload.held_s for payload in payloads) / held_s


def _newtons(force: float) -> str:
    return f"{force:.3g}" if force < 1e3 else f"{force:.0f}"
