"""The instances of a run's components, for a terminal and as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.adder.instances import ComponentInstances, Instance
from tracerisk.prm.assessment import Assessment
from tracerisk.report.tables import plain, table_of
from tracerisk.trace import FunctionRef

if TYPE_CHECKING:
    from rich.table import Table

MOST_INSTANCES = 8
"""How many instances of one component are shown, those with the greatest share first."""


def component_shares(assessment: Assessment) -> dict[str, float]:
    """Return the Fussell-Vesely importance of each component, by its name in the blocks.

    The units' own part and the common cause of a component are parameters of their own in the
    model; what goes with either is added up, which is right while failures are rare.
    """
    found: dict[str, float] = {}
    for each in assessment.components:
        name = each.name.partition(" {")[0]
        found[name] = min(1.0, found.get(name, 0.0) + each.fussell_vesely)
    return found


@dataclass(frozen=True, slots=True)
class InstanceImportance:
    """One instance beside its component.

    `share` is the part of the component's failures that is the instance's, `fussell_vesely` the
    part of the mission's failure probability that goes with it: the component's, times that of
    the instance within it (docs/theory.md#instances).
    """

    component: str
    instance: Instance
    share: float
    fussell_vesely: float


def instance_importances(
    instances: Sequence[ComponentInstances], assessment: Assessment
) -> tuple[InstanceImportance, ...]:
    """Return every instance with its importance, components as they matter, most first."""
    shares = component_shares(assessment)
    ordered = sorted(instances, key=lambda each: -shares.get(each.component.name, 0.0))
    return tuple(
        InstanceImportance(
            each.component.name,
            instance,
            instance.share,
            instance.fussell_vesely * shares.get(each.component.name, 0.0),
        )
        for each in ordered
        for instance in sorted(each.instances, key=lambda one: -one.share)
    )


def instances_data(
    importances: Sequence[InstanceImportance], names: Mapping[FunctionRef, str]
) -> list[dict[str, Any]]:
    """Return all instances as data; `names` are the functions' names in the model."""
    return [
        {
            "component": each.component,
            "instance": each.instance.element,
            "units": each.instance.units,
            "p_failure": each.instance.p_failure,
            "share": each.share,
            "fussell_vesely": each.fussell_vesely,
            "per_visit": {names[ref]: p for ref, p in each.instance.per_visit.items()},
        }
        for each in importances
    ]


def instances_table(
    instances: Sequence[ComponentInstances], importances: Sequence[InstanceImportance]
) -> Table | None:
    """Return the table of the components whose instances differ; `None` where none do."""
    unlike = {each.component.name for each in instances if not each.are_alike}
    if not unlike:
        return None
    table = table_of("Instances that differ")
    table.add_column("component", overflow="fold")
    table.add_column("instance", overflow="fold")
    for heading in ("p mission", "share", "Fussell-Vesely"):
        table.add_column(heading, justify="right", no_wrap=True)
    shown: dict[str, int] = {}
    for each in importances:
        if each.component not in unlike:
            continue
        number = shown[each.component] = shown.get(each.component, 0) + 1
        if number <= MOST_INSTANCES:
            table.add_row(
                *plain(
                    [
                        each.component if number == 1 else "",
                        each.instance.element,
                        f"{each.instance.p_failure:.2e}",
                        f"{100.0 * each.share:.3g} %",
                        f"{100.0 * each.fussell_vesely:.3g} %",
                    ]
                )
            )
        elif number == MOST_INSTANCES + 1:
            left = sum(one.component == each.component for one in importances) - MOST_INSTANCES
            table.add_row(*plain(["", f"and {left} more", "", "", ""]))
    return table
