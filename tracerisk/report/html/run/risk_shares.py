"""Which part of the mission's failure probability goes with which element, by function.

The replay colours the links of the arm by it, and fills them up as time goes on.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.sources import block_links
from tracerisk.report.instances import component_shares

RISK = "replay-risk"
"""The id of the data within the page."""

_DIGITS = 9


def shares_by_function(assessment: Assessment) -> dict[tuple[str, str], float]:
    """Return the part of the failure probability by function and component, in [0, 1].

    A component's Fussell-Vesely importance is parted among functions as its criticality is.
    """
    shares: dict[tuple[str, str], float] = {}
    critical: dict[str, dict[str, float]] = {}
    for importance in assessment.components:
        parts = critical.setdefault(importance.component, {})
        for part in importance.by_state:
            parts[part.name] = parts.get(part.name, 0.0) + part.criticality
    for component, share in component_shares(assessment).items():
        total = sum(critical[component].values())
        for function, criticality in critical[component].items():
            if total > 0.0 and criticality > 0.0:
                shares[function, component] = share * criticality / total
    return shares


def risk_data(report: ReportInput) -> dict[str, Any]:
    """Return what the script of the replay reads of the risk, as JSON has it.

    `shares` are rows of function, component, element and part; the element is `None` for a
    component that the twin sees nowhere. `blocks` link each function to its block.
    """
    rows = []
    for (function, component), share in sorted(shares_by_function(report.assessment).items()):
        elements = _elements(report, function, component) or {None: 1.0}
        for element, part in elements.items():
            rows.append([function, component, element, round(share * part, _DIGITS)])
    return {"shares": rows, "blocks": block_links(report.sources)}


def _elements(report: ReportInput, function: str, component: str) -> Mapping[str | None, float]:
    """Return how the elements of a component share its failures in a function."""
    if report.figures is None:
        return {}
    refs = [ref for ref, name in report.names.items() if name == function]
    chances = {
        instance.element: instance.units * instance.per_visit[ref]
        for item in report.figures.instances
        if item.component.name == component
        for instance in item.instances
        for ref in refs
        if ref in instance.per_visit
    }
    total = sum(chances.values())
    return {element: chance / total for element, chance in chances.items()} if total else {}
