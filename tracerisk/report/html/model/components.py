"""Which component matters how much, and where its figures come from."""

from __future__ import annotations

from tracerisk.common.hardware.model import Component, Hardware
from tracerisk.prm.hybrid.assessment import ComponentImportance
from tracerisk.report.hardware_table import figure_lines
from tracerisk.report.html import figures
from tracerisk.report.html.notes import by_hand, listed
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Section
from tracerisk.report.html.tables import (
    Cell,
    Column,
    Table,
    numbers,
    row_of,
    share_cell,
    texts,
)
from tracerisk.report.run_figures import RunFigures

_MEANINGS = (
    (
        "Fussell-Vesely",
        "how much of the mission's failure probability would be gone if the component never failed",
    ),
    (
        "criticality",
        "how the mission's figure moves with the component's own: at 50 %, a tenth less of the "
        "one is a twentieth less of the other; where a better part or better data pays first",
    ),
    (
        "Birnbaum",
        "how steeply the mission's figure rises with the component's own; not bounded by one",
    ),
    (
        "risk reduction worth",
        "how many times smaller the mission's figure would be if the component never failed",
    ),
    (
        "risk achievement worth",
        "how many times greater it would be if the component had failed wherever it is used; "
        "the same for every component that ends the mission alone",
    ),
    ("tenfold", "how many times greater it would be if the component failed ten times as often"),
)


def importance_section(report: ReportInput) -> Section:
    """Return every importance measure of every component, and what each means in plain words."""
    components = report.assessment.components
    html = rendered(
        "importance.html.j2",
        table=_measures(components) if components else None,
        instances=_by_instance(report.figures),
        units=_by_unit(components),
        meanings=_MEANINGS,
    )
    return Section("importance", "Importance", html)


def hardware_section(report: ReportInput) -> Section | None:
    """Return the figures of the hardware description; `None` where none is known."""
    hardware = report.hardware
    if hardware is None:
        return None
    used = {parameter.component for parameter in report.assessment.components}
    html = rendered(
        "hardware.html.j2",
        table=_described(report, hardware, used),
        hardware=hardware,
        assumed=_assumed(report.figures),
    )
    return Section("hardware", "Components", html)


def _measures(components: tuple[ComponentImportance, ...]) -> Table:
    columns = (
        Column("component"),
        *numbers("Fussell-Vesely", "criticality", "Birnbaum", "RRW", "RAW", "tenfold"),
        Column("one unit", "greatest in a visit", is_number=True),
    )
    rows = tuple(
        row_of(
            Cell(component.name, component=component.component),
            share_cell(component.fussell_vesely),
            figures.percent(component.criticality),
            figures.ratio(component.birnbaum),
            figures.ratio(component.risk_reduction_worth),
            figures.ratio(component.risk_achievement_worth),
            figures.ratio(component.tenfold),
            figures.probability(component.theta),
            component=component.component,
        )
        for component in components
    )
    return Table("importance", "Importance of the components over the mission", columns, rows)


def _by_instance(found: RunFigures | None) -> Table | None:
    """Return what each instance does by itself; `None` where all of a component are alike."""
    if found is None:
        return None
    unlike = {instance.component.name for instance in found.instances if not instance.are_alike}
    rows = tuple(
        row_of(
            Cell(importance.component, component=importance.component),
            importance.instance.element,
            figures.probability(importance.instance.p_failure),
            share_cell(importance.share),
            figures.percent(importance.fussell_vesely),
            component=importance.component,
        )
        for importance in found.importances
        if importance.component in unlike
    )
    columns = (
        *texts("component", "instance"),
        Column("fails", "in a mission", is_number=True),
        Column("share", "of the component's failures", is_number=True),
        Column("Fussell-Vesely", is_number=True),
    )
    return Table("instances", "Instances that differ", columns, rows) if rows else None


def _assumed(found: RunFigures | None) -> Table | None:
    """Return the assumed figures that the result hangs on; `None` for none."""
    if found is None or not found.assumed:
        return None
    rows = tuple(
        row_of(
            Cell(assumed_figure.component, component=assumed_figure.component),
            share_cell(assumed_figure.fussell_vesely),
            assumed_figure.source,
            component=assumed_figure.component,
        )
        for assumed_figure in found.assumed
    )
    columns = (Column("component"), Column("share", is_number=True), Column("source"))
    return Table("assumed", "Assumed figures that the result hangs on", columns, rows)


def _by_unit(components: tuple[ComponentImportance, ...]) -> Table | None:
    """Return the shares of single units, of components that have several; `None` for none."""
    rows = tuple(
        row_of(
            Cell(component.name, component=component.component),
            part.name,
            figures.ratio(part.birnbaum),
            figures.percent(part.criticality),
            component=component.component,
        )
        for component in components
        if len(component.by_unit) > 1
        for part in component.by_unit
    )
    columns = (*texts("component", "unit"), *numbers("Birnbaum", "criticality"))
    return Table("units", "Importance of single units", columns, rows) if rows else None


def _described(report: ReportInput, hardware: Hardware, used: set[str]) -> Table:
    pinned = by_hand(report.pins)
    has_sources = any(_source(component) for component in hardware.components)
    columns = (
        *texts("component", "units", "redundancy", "figures of one unit"),
        *texts(*(["source"] if has_sources else []), "in this mission"),
    )
    rows = tuple(
        row_of(
            Cell(component.name, component=component.name if component.name in used else None),
            _units(component, report),
            _redundancy(component),
            "; ".join(figure_lines(component)),
            *([_source(component) or figures.NOTHING] if has_sources else []),
            Cell(
                "used" if component.name in used else "not used",
                note=f"by hand in {listed(pinned[component.name])}"
                if component.name in pinned
                else "",
            ),
            component=component.name,
        )
        for component in hardware.components
    )
    return Table("hardware", "Hardware description", columns, rows)


def _units(component: Component, report: ReportInput) -> str:
    """Return how many units there are, as many as the run found where the robot says it."""
    if component.quantity is not None:
        return str(component.quantity)
    units = {
        used.units
        for state in report.assessment.states
        for used in state.components
        if used.component == component.name
    }
    return str(max(units)) if units else "as the robot has"


def _redundancy(component: Component) -> str:
    redundancy = component.redundancy
    if not redundancy:
        return "none: each is needed"
    message = f"{redundancy.required} must work"
    if redundancy.has_spares:
        message += ", spares"
    if redundancy.common_cause:
        message += f", common cause {figures.percent(redundancy.common_cause)}"
    return message


def _source(component: Component) -> str:
    return "; ".join(component.sources())
