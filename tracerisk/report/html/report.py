"""The report: its sections in their order, put into one page."""

from __future__ import annotations

from tracerisk.report.html.difference import difference_section
from tracerisk.report.html.model.chain import chain_section
from tracerisk.report.html.model.components import hardware_section, importance_section
from tracerisk.report.html.model.fault_trees import fault_trees_section
from tracerisk.report.html.model.functions import functions_section
from tracerisk.report.html.notes import (
    assumptions_section,
    coverage_section,
    findings_section,
    pins_section,
)
from tracerisk.report.html.page import page
from tracerisk.report.html.record import record_section
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.run.brought_about import brought_about_section
from tracerisk.report.html.run.contact_pairs import touches_section
from tracerisk.report.html.run.timeline import NAME as RUN
from tracerisk.report.html.sources import sources_section
from tracerisk.report.html.summary import lead, sheet


def render_report(report: ReportInput) -> str:
    """Return the report as one HTML page, the same for the same input."""
    run = [section for section in report.sections if section.name == RUN]
    sections = (
        *run,
        difference_section(report),
        *(section for section in report.sections if section.name != RUN),
        brought_about_section(report),
        functions_section(report),
        touches_section(report),
        chain_section(report),
        fault_trees_section(report),
        importance_section(report),
        hardware_section(report),
        findings_section(report),
        coverage_section(report),
        pins_section(report),
        assumptions_section(report),
        record_section(report),
        sources_section(report),
    )
    shown = tuple(section for section in sections if section is not None)
    connects = any(section.is_bare for section in shown)
    title = f"Risk of {report.model.name}"
    return page(title, lead(report), shown, connects=connects, sheet=sheet(report, title))
