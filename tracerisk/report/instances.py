"""The instances of a run's components, for a terminal and as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.adder.figures.instances import ComponentInstances, Instance
from tracerisk.common.function_ref import FunctionRef
from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.report.tables import (
    ROOMY,
    WIDE,
    add_share_columns,
    plain,
    share_cells,
    share_text,
    table_of,
)

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

MOST_INSTANCES = 8
"""How many instances of one component are shown, those with the greatest share first."""

MOST_OF_OTHERS = 3
"""How many in 80 columns, of each component but the one that matters most."""

_TITLE = "Instances that differ"


def component_shares(assessment: Assessment) -> dict[str, float]:
    """Return the Fussell-Vesely importance of each component, by its name in the blocks.

    The units' own part and the common cause of a component are parameters of their own in the
    model; what goes with either is added up, which is right while failures are rare.
    """
    values: dict[str, float] = {}
    for component in assessment.components:
        name = component.component
        values[name] = min(1.0, values.get(name, 0.0) + component.fussell_vesely)
    return values


@dataclass(frozen=True, slots=True)
class InstanceImportance:
    """One instance beside its component (docs/theory.md#instances)."""

    component: str
    """Name of the component."""
    instance: Instance
    """The instance, such as one joint."""
    share: float
    """Part of the component's failures that the instance has, in [0, 1]."""
    fussell_vesely: float
    """Part of the mission's failure probability that goes with it: the component's part times
    the instance's part within it."""


def instance_importances(
    instances: Sequence[ComponentInstances], assessment: Assessment
) -> tuple[InstanceImportance, ...]:
    """Return every instance with its importance, components as they matter, most first."""
    shares = component_shares(assessment)
    ordered = sorted(instances, key=lambda item: -shares.get(item.component.name, 0.0))
    return tuple(
        InstanceImportance(
            item.component.name,
            instance,
            instance.share,
            instance.fussell_vesely * shares.get(item.component.name, 0.0),
        )
        for item in ordered
        for instance in sorted(item.instances, key=lambda one: -one.share)
    )


def instances_data(
    importances: Sequence[InstanceImportance], names: Mapping[FunctionRef, str]
) -> list[dict[str, Any]]:
    """Return all instances as data; `names` are the functions' names in the model."""
    return [
        {
            "component": importance.component,
            "instance": importance.instance.element,
            "units": importance.instance.units,
            "p_failure": importance.instance.p_failure,
            "share": importance.share,
            "fussell_vesely": importance.fussell_vesely,
            "per_visit": {names[ref]: p for ref, p in importance.instance.per_visit.items()},
        }
        for importance in importances
    ]


def instances_table(
    instances: Sequence[ComponentInstances],
    importances: Sequence[InstanceImportance],
    width: int = 80,
) -> RenderableType | None:
    """Return the components whose instances differ; `None` where none do.

    On a wide terminal they stand side by side.
    """
    unlike = {instance.component.name for instance in instances if not instance.are_alike}
    rows: dict[str, list[InstanceImportance]] = {}
    for importance in importances:
        if importance.component in unlike:
            rows.setdefault(importance.component, []).append(importance)
    if not rows:
        return None
    return _side_by_side(rows, width) if width >= WIDE else _stacked(rows, width)


def _stacked(rows: Mapping[str, Sequence[InstanceImportance]], width: int) -> Table:
    headings = ("p mission", "share", *(("Fussell-Vesely",) if width >= ROOMY else ()))
    table = table_of(_TITLE, ("component", "instance"), headings)
    most = MOST_INSTANCES
    for component, importances in rows.items():
        shown, left = _shown(importances, most)
        for index, importance in enumerate(shown):
            cells = [
                component if index == 0 else "",
                importance.instance.element,
                f"{importance.instance.p_failure:.2e}",
                share_text(importance.share),
                share_text(importance.fussell_vesely),
            ]
            table.add_row(*plain(cells[: 2 + len(headings)]))
        if left:
            table.add_row(*plain(["", f"and {left} more"]))
        most = MOST_OF_OTHERS
    return table


def _side_by_side(rows: Mapping[str, Sequence[InstanceImportance]], width: int) -> RenderableType:
    from rich.columns import Columns
    from rich.console import Group
    from rich.text import Text

    tables = []
    for component, importances in rows.items():
        table = table_of(component, style="")
        table.add_column("instance", overflow="fold", max_width=24)
        table.add_column("p mission", justify="right", no_wrap=True)
        add_share_columns(table, width)
        shown, left = _shown(importances, MOST_INSTANCES)
        for importance in shown:
            names = plain([importance.instance.element, f"{importance.instance.p_failure:.2e}"])
            table.add_row(*names, *share_cells(importance.share, width))
        if left:
            table.add_row(*plain([f"and {left} more"]))
        tables.append(table)
    return Group(Text(f"{_TITLE}, each by its share of the component", "bold"), Columns(tables))


def _shown(
    found: Sequence[InstanceImportance], most: int
) -> tuple[Sequence[InstanceImportance], int]:
    """Return what is shown, and the number of the rest, which is never one."""
    if len(found) <= most + 1:
        return found, 0
    return found[:most], len(found) - most
