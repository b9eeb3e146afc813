"""The instances behind a block's one value: what each unit of a component does by itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tracerisk.adder.figures.instance_values import are_alike
from tracerisk.adder.quantify.component_activity import ComponentUse
from tracerisk.adder.quantify.figure_shares import EndingShare
from tracerisk.adder.quantify.function_use import FunctionUse, mean_probability, mission_probability
from tracerisk.adder.quantify.instance_shares import InstanceShare, instance_shares
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.hardware.model import Component


@dataclass(frozen=True, slots=True)
class Instance:
    """One unit of a component, or several that share an element of the robot."""

    element: str
    """The name of the element."""
    units: int
    """The number of units that share it."""
    per_visit: Mapping[FunctionRef, float]
    """The failure probability of one unit in one visit, by function, from its mean hazard."""
    p_failure: float
    """The failure probability of one unit over the mission."""
    fussell_vesely: float
    """The share of the component's failures in which the instance has failed, from 0 to 1."""
    share: float
    """The same share, scaled so that all instances sum to 1."""


@dataclass(frozen=True, slots=True)
class ComponentInstances:
    """A component of the description and its instances."""

    component: Component
    """The component as it is described."""
    instances: tuple[Instance, ...]
    """The instances, in the order of the elements; empty where the twin sees none."""
    figure_shares: tuple[float, ...] = ()
    """The part of the component's hazard over the mission by each figure, (n_figures,); empty
    where it is not used."""
    ending: EndingShare | None = None
    """The share of the hazard that ends the mission; `None` where no evidence gives it."""

    @property
    def are_alike(self) -> bool:
        """Whether all have the same failure probability over the mission, within noise."""
        return are_alike(instance.p_failure for instance in self.instances)

    def in_function(self, function: FunctionRef) -> dict[str, float]:
        """Return the failure probability of each element in one visit; nothing if not used."""
        return {
            instance.element: instance.per_visit[function]
            for instance in self.instances
            if function in instance.per_visit
        }


def instances_of(used: ComponentUse, uses: Mapping[FunctionRef, FunctionUse]) -> ComponentInstances:
    """Return the instances of a component, from its units' probabilities in each function.

    A component that the twin sees nowhere has none: its units are alike.
    """
    if not uses or any(unit.element is None for unit in used.units):
        return ComponentInstances(used.component, ())
    places: dict[str, list[int]] = {}
    for number, unit in enumerate(used.units):
        places.setdefault(str(unit.element), []).append(number)
    shares = _shares(used, list(uses.values()), len(places))
    instances = []
    for element, units in places.items():
        first = units[0]
        instances.append(
            Instance(
                element=element,
                units=len(units),
                per_visit={
                    ref: mean_probability([[row[first]] for row in use.visits])
                    for ref, use in uses.items()
                },
                p_failure=shares[first].p_failure,
                fussell_vesely=shares[first].fussell_vesely,
                share=shares[first].share,
            )
        )
    return ComponentInstances(used.component, tuple(instances))


def _shares(
    used: ComponentUse, functions: list[FunctionUse], places: int
) -> tuple[InstanceShare, ...]:
    if places > 1:
        return instance_shares(functions, used.component.redundancy)
    p_failure = mission_probability(functions, 0)
    fails = float(p_failure > 0.0)
    return (InstanceShare(p_failure, fails, fails),)
