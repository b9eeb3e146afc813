"""A solved dynamic tree, and how much its top hangs on each event."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tracerisk.prm.numbers.probability import Probability, worth
from tracerisk.prm.numbers.table import Table
from tracerisk.prm.other_models.dynamic.elements import DynamicEvent
from tracerisk.prm.other_models.dynamic.group_model import DynamicGroup
from tracerisk.prm.trees.events import FailureModel
from tracerisk.prm.trees.failure_models import GLM, Constant, Erlang, Exponential
from tracerisk.prm.trees.fault_tree import FaultTree

if TYPE_CHECKING:
    from tracerisk.prm.other_models.dynamic.tree import DynamicTree


@dataclass(frozen=True, slots=True)
class DynamicImportance:
    """How much a top event's probability P depends on one event.

    P0 is the top's probability where the event never happens, P1 where it is failed from the start.
    An event of a gate for which order counts may prevent more than it causes: then P0 is greater
    than P.
    """

    name: str
    """Name of the event."""
    probability: float
    """Probability of the event in service for the whole mission."""
    fussell_vesely: float
    """(P-P0)/P."""
    risk_reduction_worth: float
    """P/P0; infinite where P0 is zero."""
    risk_achievement_worth: float
    """P1/P."""
    tenfold: float
    """P with ten times the event's rate or probability, over P."""


@dataclass(frozen=True, slots=True)
class DynamicSolution:
    """A dynamic tree and the mission it was solved for."""

    tree: DynamicTree
    """The tree that was solved."""
    mission_time_h: float
    """Length of the mission [h]."""
    top: Probability
    """Probability of the top event, with its complement."""

    @property
    def probability(self) -> float:
        """The probability of the top event."""
        return self.top.p

    def importance(self) -> Table[DynamicImportance]:
        """Return the importance of each event, the greatest first.

        The groups of the events are solved anew for each of the three figures. The share of an
        event is a difference where the event is in a group: right to 1e-12 of P, not of itself.
        Raises as `DynamicTree.probability` does.
        """
        static = self.tree.static_tree()
        values = static.values_at(self.mission_time_h)
        total = static.probability(values).p
        group_of = {
            inner.name: (event.name, event.model.tree)
            for event in static.events
            if isinstance(event.model, DynamicGroup)
            for inner in event.model.tree.events
        }
        rows = []
        for event in self.tree.events:
            without, failed, tenfold = (
                self._changed(static, values, group_of.get(event.name), event, model)
                for model in (Constant(0.0), Constant(1.0), _tenfold(event.model))
            )
            share = (
                static.drop_without(event.name, values)
                if event.name not in group_of
                else total - without
            )
            rows.append(
                DynamicImportance(
                    name=event.name,
                    probability=event.model.probability(self.mission_time_h).p,
                    fussell_vesely=share / total if total > 0.0 else 0.0,
                    risk_reduction_worth=worth(total, without),
                    risk_achievement_worth=worth(failed, total),
                    tenfold=worth(tenfold, total),
                )
            )
        rows.sort(key=lambda row: (-abs(row.fussell_vesely), -row.tenfold, row.name))
        return Table(tuple(rows))

    def _changed(
        self,
        static: FaultTree,
        values: dict[str, float],
        group: tuple[str, DynamicTree] | None,
        event: DynamicEvent,
        model: FailureModel | None,
    ) -> float:
        """Return the top's probability with another model for an event."""
        if group is None:
            p = (
                min(10.0 * values[event.name], 1.0)
                if model is None
                else model.probability(self.mission_time_h).p
            )
            return static.probability({**values, event.name: p}).p
        name, inside = group
        # An event in a group has a rate or a probability: each has its tenfold.
        assert model is not None
        changed = replace(
            inside,
            events=tuple(
                replace(one, model=model) if one.name == event.name else one
                for one in inside.events
            ),
        )
        p = DynamicGroup(changed).probability(self.mission_time_h).p
        return static.probability({**values, name: p}).p

    def _repr_html_(self) -> str:
        from html import escape

        return f"<p>{escape(self.tree.top)}: {self.top.p:.6g}</p>{self.importance()._repr_html_()}"


def _tenfold(model: FailureModel) -> FailureModel | None:
    """Return the model with ten times the rate or the probability; none where it has neither."""
    if isinstance(model, Exponential | Erlang):
        return replace(model, rate=10.0 * model.rate)
    if isinstance(model, GLM):
        return replace(
            model,
            failure_on_demand=min(10.0 * model.failure_on_demand, 1.0),
            failure_rate=10.0 * model.failure_rate,
        )
    if hasattr(model, "p"):
        return Constant(min(10.0 * model.probability(0.0).p, 1.0))
    return None
