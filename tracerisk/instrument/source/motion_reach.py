"""Which functions of a source can reach a motion command, and which of them never ran."""

from __future__ import annotations

from collections.abc import Collection

from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.verdict import Uncovered
from tracerisk.instrument.source.call_graph import CallGraph
from tracerisk.instrument.source.function_definitions import MODULE
from tracerisk.instrument.source.python_source import FunctionSite


def motion_reaching(
    graph: CallGraph, motion_names: Collection[str], hidden: Collection[FunctionRef] = ()
) -> tuple[FunctionSite, ...]:
    """Return the functions that can reach a motion command, in the order of files and lines.

    `motion_names` are the names of calls that command motion, as they are written
    (`self.arm.go`) or the last of each (`go`); `hidden` are functions that may command by others.
    """
    callers: dict[FunctionRef, set[FunctionRef]] = {}
    for ref, calls in graph.calls.items():
        for callee in calls.functions:
            callers.setdefault(callee, set()).add(ref)
    names = frozenset(motion_names)
    pending = [ref for ref, calls in graph.calls.items() if calls.others & names or ref in hidden]
    reaching = set(pending)
    while pending:
        new = callers.get(pending.pop(), set()) - reaching
        reaching |= new
        pending += new
    sites = (FunctionSite(ref, graph.calls[ref].line) for ref in reaching)
    return tuple(sorted(sites, key=lambda site: (site.ref.file, site.line, site.ref.name)))


def uncovered(
    graph: CallGraph,
    motion_names: Collection[str],
    ran: Collection[FunctionRef],
    hidden: Collection[FunctionRef] = (),
) -> tuple[Uncovered, ...]:
    """Return the functions that can reach a motion command and are not among those that `ran`.

    Of those that ran it is known what they command, `hidden` ones too.
    """
    fallback = _fallback(graph, ran)
    return tuple(
        Uncovered(site.ref, site.line, is_spare=site.ref in fallback)
        for site in motion_reaching(graph, motion_names, set(hidden) - set(ran))
        if site.ref not in ran and site.ref.name != MODULE
    )


def _fallback(graph: CallGraph, ran: Collection[FunctionRef]) -> frozenset[FunctionRef]:
    """Return the functions reached only through `except` clauses of functions that `ran`."""
    never = {ref for ref in graph.calls if ref not in ran and ref.name != MODULE}
    fallback: set[FunctionRef] = set()
    pending = [ref for ref in graph.calls if ref not in never]
    while pending:
        new = (graph.calls[pending.pop()].functions & never) - fallback
        fallback |= new
        pending += new
    # A function called outside `except` clauses by one that is no fallback is not one either.
    pending = [ref for ref in graph.calls if ref not in fallback]
    while pending:
        lost = graph.regular[pending.pop()].functions & fallback
        fallback -= lost
        pending += lost
    return frozenset(fallback)
