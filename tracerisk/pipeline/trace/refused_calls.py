"""Which calls that a stand-in refused are settled, for the controller had another way."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from tracerisk.errors import Location
from tracerisk.instrument.call_marks import Calls, marked_calls
from tracerisk.source.dotted_names import last_name
from tracerisk.source.python_source import parsed
from tracerisk.trace import Finding, RunEnd

if TYPE_CHECKING:
    from tracerisk.pipeline.workspace.controller import Controller

REFUSED = "call_raised"
"""The kind of the finding of a call that a stand-in refused by an exception which was caught."""


def with_settled_refusals(
    findings: Sequence[Finding], calls: Calls | None, controller: Controller, end: RunEnd
) -> tuple[Finding, ...]:
    """Return the findings, those of refused calls as recovered where they need no report.

    That is so where the same call succeeded later, where an `except` clause called the same with
    success (another name of the group), and where another finding or the end of the run has the
    same line.
    """
    told = {_line(finding.location) for finding in findings if finding.kind != REFUSED}
    if not end.is_good:
        told.add(_line(end.location))
    return tuple(
        replace(finding, recovered_s=finding.time_s)
        if finding.kind == REFUSED
        and (_line(finding.location) in told or _has_another_way(finding, calls, controller))
        else finding
        for finding in findings
    )


def _line(place: Location | None) -> tuple[str, int | None] | None:
    return None if place is None else (place.file, place.line)


def _has_another_way(finding: Finding, calls: Calls | None, controller: Controller) -> bool:
    place = finding.location
    if calls is None or place is None or place.line is None or place.column is None:
        return False
    site = (place.line, place.column)
    succeeded = calls.executed - calls.raised
    if (place.file, site) in succeeded:
        return True
    tree = parsed(controller.source_of(place.file))
    if tree is None:
        return False
    marked = {id(call.node): call for call in marked_calls(tree)}
    for attempt in (node for node in ast.walk(tree) if isinstance(node, ast.Try)):
        within = [
            marked[id(node)].node
            for statement in attempt.body
            for node in ast.walk(statement)
            if id(node) in marked and marked[id(node)].site == site
        ]
        others = [
            marked[id(node)]
            for handler in attempt.handlers
            for node in ast.walk(handler)
            if id(node) in marked
        ]
        for refused in within:
            name = last_name(refused.func)
            if any(
                last_name(other.node.func) == name and (place.file, other.site) in succeeded
                for other in others
            ):
                return True
    return False
