"""Fault trees of Galileo, as `solve` takes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

from tracerisk.cli.solving.solved import Render, Solved, chosen, no_mission_time
from tracerisk.errors import InputError, ModelError, one_of
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.dynamic import DynamicEvent, DynamicTree
from tracerisk.prm.other_models.dynamic.first_failure import (
    first_failure,
    has_repair,
    without_repair,
)
from tracerisk.prm.other_models.formats import galileo
from tracerisk.prm.trees.failure_models import GLM, Constant, Erlang, Exponential, PerDemand
from tracerisk.report.model_files import render_top_importance, render_tops

if TYPE_CHECKING:
    from tracerisk.prm.questions.uncertainty import Uncertainty


@dataclass(frozen=True, slots=True)
class DynamicFile:
    """A Galileo file; its figure is its top."""

    tree: DynamicTree
    """The dynamic fault tree, with the changes."""
    mission_time_h: float | None
    """The mission time [h]; `None` where it is not given."""
    text: str = ""
    """The Galileo text that the tree was read from."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    """The values of the parameters that the file declares, by name."""
    changes: Mapping[str, float] = field(default_factory=dict)
    """The rates [1/h] or probabilities of events that were set, by name."""

    @property
    def name(self) -> str:
        """The name of the top."""
        return self.tree.top

    def with_values(self, values: Mapping[str, float]) -> DynamicFile:
        """Return the tree with parameters, and rates or probabilities of events, set."""
        if not self.parameters.keys().isdisjoint(values):
            own = {name: values.get(name, value) for name, value in self.parameters.items()}
            tree = galileo.loads(self.text, self.name, own)
            rest = {name: value for name, value in values.items() if name not in own}
            again = replace(self, tree=tree, parameters=own, changes={})
            return again.with_values({**self.changes, **rest})
        for name, value in values.items():
            event = self._event(name)
            if isinstance(event.model, Constant | PerDemand) and not 0.0 <= value <= 1.0:
                raise InputError(f"event '{name}': {value!r} is not a probability; give 0 to 1")
            if value < 0.0:
                raise InputError(f"event '{name}': the rate {value!r} is below zero")
        events = tuple(
            _changed(dynamic_event, values[dynamic_event.name])
            if dynamic_event.name in values
            else dynamic_event
            for dynamic_event in self.tree.events
        )
        changes = {**self.changes, **values}
        return replace(self, tree=replace(self.tree, events=events), changes=changes)

    def value_of(self, name: str) -> float:
        """Return the value of a parameter, or the rate or probability of an event."""
        if name in self.parameters:
            return self.parameters[name]
        model = self._event(name).model
        if isinstance(model, GLM):
            return model.failure_rate
        return model.rate if isinstance(model, Exponential | Erlang) else model.probability(0.0).p

    def solve(self, figure: str | None, *, importance: bool) -> Solved:
        """Solve the tree."""
        again = (f"{self.name} at any time",) if has_repair(self.tree) else ()
        asked = chosen((self.name, *again), figure, self.name)
        fixed = all(isinstance(event.model, Constant | PerDemand) for event in self.tree.events)
        if self.mission_time_h is None and not fixed:
            raise no_mission_time(self.name)
        solution = self.tree.solve(mission_time_h=self.mission_time_h or 0.0)
        pair = solution.top
        top: dict[str, Any] = {"name": self.name, "probability": pair.p, "complement": pair.q}
        tops: dict[str, Probability] = {self.name: pair}
        notes: tuple[str, ...] = ()
        if again:
            ever, notes = self._at_any_time()
            top["at_any_time"] = {
                "probability": ever.p,
                "complement": ever.q,
                "is_bound": len(notes) > 1,
            }
            tops[again[0]] = ever
        tops = {name: solved for name, solved in tops.items() if name in asked}
        shown: list[tuple[Render, tuple[Any, ...]]] = [(render_tops, (self.name, tops))]
        if importance:
            rows = tuple(solution.importance())
            top["importance"] = [asdict(row) for row in rows]
            shown.append((render_top_importance, (self.name, rows)))
        figures = {name: solved.p for name, solved in tops.items()}
        # What was repaired in the mission failed in it all the same: the limit is for that.
        return Solved(figures, {"tops": [top]}, tuple(shown), notes, (asked[-1],))

    def _at_any_time(self) -> tuple[Probability, tuple[str, ...]]:
        """Return the probability of a failure at any time, and the notes on it.

        Where it cannot be found it is bounded from above by the tree without repair.
        """
        notes = (f"{self.name}: failed at the end of the mission, if not repaired before",)
        try:
            return first_failure(self.tree, self.mission_time_h or 0.0), notes
        except ModelError as error:
            tree = without_repair(self.tree)
            why = f"{self.name} at any time: bounded from above by the tree without repair: {error}"
            return tree.probability(self.mission_time_h or 0.0), (*notes, why)

    def at(self, mission_time_h: float) -> DynamicFile:
        """Return the tree with another mission time."""
        return replace(self, mission_time_h=mission_time_h)

    def spread(self, figure: str | None, samples: int, seed: int) -> Uncertainty:  # noqa: ARG002
        """Raise InputError: Galileo has no distributions."""
        raise InputError(
            "--uncertainty needs distributions, which Galileo has none of; it goes with "
            "Open-PSA, linked models and models of functions"
        )

    def _event(self, name: str) -> DynamicEvent:
        events = {dynamic_event.name: dynamic_event for dynamic_event in self.tree.events}
        if name not in events:
            raise InputError(f"there is no event '{name}'; {one_of(events, name)}")
        event = events[name]
        if not isinstance(event.model, Constant | PerDemand | Exponential | Erlang | GLM):
            raise InputError(
                f"event '{name}' has neither one rate nor a probability, but "
                f"{type(event.model).__name__}; change it in the model"
            )
        return event


def _changed(event: DynamicEvent, value: float) -> DynamicEvent:
    if isinstance(event.model, GLM):
        return replace(event, model=replace(event.model, failure_rate=value))
    if isinstance(event.model, Exponential | Erlang):
        return replace(event, model=replace(event.model, rate=value))
    return replace(event, model=Constant(value))
