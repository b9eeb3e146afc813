"""A solved fault tree, and how much its top depends on each figure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.probability import Probability, pair_of, value_of, worth
from tracerisk.prm.numbers.quantities import check_parameters

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Literal

    from tracerisk.prm.numbers.table import Table
    from tracerisk.prm.trees.fault_tree import FaultTree


@dataclass(frozen=True, slots=True)
class EventImportance:
    """How much a top event's probability P depends on the probability p of one figure.

    P0 and P1 are the top's probability at p = 0 and p = 1.
    Where P is zero, criticality, Fussell-Vesely and the diagnostic importance are zero, the ratios
    one or infinite.
    Source: M. van der Borst, H. Schoonakker, "An overview of PSA importance measures",
    Reliability Engineering and System Safety 72 (2001).
    """

    name: str
    """Name of the parameter, or of the event in a table by event."""
    probability: float
    """Probability p of one event."""
    birnbaum: float
    """Derivative dP/dp."""
    criticality: float
    """p/P dP/dp."""
    fussell_vesely: float
    """(P-P0)/P."""
    risk_reduction_worth: float
    """P/P0; infinite where P0 is zero."""
    risk_achievement_worth: float
    """P1/P."""
    diagnostic_importance: float
    """p P1/P: probability that the event has happened, given that the top has."""


@dataclass(frozen=True, slots=True)
class FaultTreeSolution:
    """A fault tree with the values that it was solved for."""

    tree: FaultTree
    """The tree that was solved."""
    values: Mapping[str, float]
    """Probability of one event, by parameter."""
    top: Probability
    """Probability of the top event, with its complement."""

    @property
    def probability(self) -> float:
        """The probability of the top event."""
        return self.top.p

    def importance(self, by: Literal["parameter", "event"] = "parameter") -> Table[EventImportance]:
        """Return the importance of each parameter or of each event, the greatest first.

        A parameter that several events share changes in all of them; by event, each event is
        taken for itself.
        """
        from tracerisk.prm.numbers.table import Table

        if by not in ("parameter", "event"):
            raise ModelError(f"importance by '{by}'; {one_of(('parameter', 'event'), by)}")
        tree, values = self.tree, self.values
        if by == "event":
            events = tuple(replace(event, parameter=event.name) for event in tree.events)
            values = {event.name: values[event.parameter] for event in tree.events}
            tree = replace(tree, events=events)
        events_of: dict[str, list[str]] = {}
        for event in tree.events:
            events_of.setdefault(event.parameter, []).append(event.name)
        slopes = tree.sensitivities(values)
        conditionals = tree.conditional_tops(values)
        total = self.top.p
        rows = []
        for name, members in events_of.items():
            value = values[name]
            slope = math.fsum(slopes[member] for member in members)
            if len(members) == 1:
                # The top is linear in the probability of one event.
                failed, without = (pair.p for pair in conditionals[members[0]])
                drop = value * slope
            else:
                failed, without = (tree.probability({**values, name: p}).p for p in (1.0, 0.0))
                drop = tree.drop_without(name, values)
            rows.append(
                EventImportance(
                    name=name,
                    probability=value,
                    birnbaum=slope,
                    criticality=slope * value / total if total > 0.0 else 0.0,
                    fussell_vesely=drop / total if total > 0.0 else 0.0,
                    risk_reduction_worth=worth(total, without),
                    risk_achievement_worth=worth(failed, total),
                    diagnostic_importance=value * failed / total if total > 0.0 else 0.0,
                )
            )
        rows.sort(key=lambda row: (-abs(row.fussell_vesely), -abs(row.criticality), row.name))
        return Table(tuple(rows))

    def _repr_html_(self) -> str:
        from html import escape

        return f"<p>{escape(self.tree.top)}: {self.top.p:.6g}</p>{self.importance()._repr_html_()}"


def solve_tree(
    tree: FaultTree, values: Mapping[str, float], mission_time_h: float | None
) -> FaultTreeSolution:
    """Solve a fault tree; see FaultTree.solve."""
    parameters = dict.fromkeys(tree.parameters)
    check_parameters(values, parameters)
    given = {**tree.values_at(mission_time_h), **values}
    for event in tree.events:
        if event.parameter not in given and event.model is not None:
            raise ModelError(
                f"event '{event.name}' depends on the mission time; give mission_time_h, in hours"
            )
    top = tree.probability(given)
    return FaultTreeSolution(
        tree, {name: value_of(pair_of(given[name])) for name in parameters}, top
    )
