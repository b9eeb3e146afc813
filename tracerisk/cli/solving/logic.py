"""Fault and event trees of Open-PSA and OpenPRA, as `solve` takes them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace

from tracerisk.cli.shared.output import note
from tracerisk.cli.solving.solved import Render, Solved, chosen, no_mission_time
from tracerisk.errors import InputError, ModelError
from tracerisk.prm.other_models.logic.checks import needs_mission_time
from tracerisk.prm.other_models.logic.model import LogicModel
from tracerisk.report.model_files import render_event_tree, render_top_importance, render_tops

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from tracerisk.prm.other_models.logic.mission_parts import Alignment
    from tracerisk.prm.questions.uncertainty import Uncertainty


@dataclass(frozen=True, slots=True)
class LogicFile:
    """A model of Open-PSA or OpenPRA; its figures are its tops and outcomes."""

    model: LogicModel
    """The model, with the changes."""
    file: str
    """The path of the file."""
    mission_time_h: float | None
    """The mission time [h]; `None` where it is not given."""

    @property
    def name(self) -> str:
        """What the model is called; that of its file where it is called nothing."""
        return self.model.name or os.path.basename(self.file)  # noqa: PTH119 - no start needs pathlib

    def with_values(self, values: Mapping[str, float]) -> LogicFile:
        """Return the model with parameters, events, house events or groups set."""
        from tracerisk.prm.other_models.logic.set_figures import with_values

        return replace(self, model=with_values(self.model, values))

    def value_of(self, name: str) -> float:
        """Return the figure that the model has now; not a number where it has none."""
        from tracerisk.prm.other_models.logic.set_figures import value_of

        return value_of(self.model, name, self.mission_time_h or 0.0)

    def solve(self, figure: str | None, *, importance: bool) -> Solved:
        """Solve all tops and event trees, or one top."""
        model, time = self.model, self._time()
        begun = [
            event_tree for event_tree in model.event_trees if event_tree.tree.initiating is not None
        ]
        if not model.tops and not begun:
            raise InputError(f"'{self.name}' has no gates and no event tree; there is no figure")
        tops: dict[str, tuple[float, float]] = {}
        data: dict[str, Any] = {}
        importances: dict[str, Any] = {}
        gates = model.gates_by_name
        wanted = model.tops if figure is None else (figure,) if figure in gates else ()
        for top in wanted:
            tree = model.fault_tree(top, mission_time_h=time)
            solution = tree.solve(tree.values_at(time), mission_time_h=time)
            tops[top] = (solution.top.p, solution.top.q)
            if importance:
                importances[top] = tuple(solution.importance())
        data["tops"] = _tops_data(tops)
        for item in data["tops"] if importance else ():
            item["importance"] = [asdict(one) for one in importances[item["name"]]]
        figures = {top: p for top, (p, _) in tops.items()}
        shown: list[tuple[Render, tuple[Any, ...]]] = []
        if tops:
            shown.append((render_tops, (self.name, tops)))
        shown += [
            (render_top_importance, (top, event_trees)) for top, event_trees in importances.items()
        ]
        notes = list(model.findings)
        if wanted and model.alignments:
            data["phases"] = phases = self._phases(wanted, time)
            shown += [(render_tops, (phase["name"], phase["tops"])) for phase in phases]
            for phase in phases:
                solved: dict[str, tuple[float, float]] = phase["tops"]
                figures |= {f"{top} ({phase['name']})": p for top, (p, _) in solved.items()}
                phase["tops"] = _tops_data(solved)
            data["missions"] = []
            for alignment in model.alignments:
                ever = self._in_any_phase(alignment, wanted, time, notes)
                if ever:
                    name = f"{alignment.name}, any phase"
                    data["missions"].append({"name": name, "tops": _tops_data(ever)})
                    shown.append((render_tops, (name, ever)))
                    figures |= {f"{top} ({name})": p for top, (p, _) in ever.items()}
        risks = tuple(figures) or None
        if model.alignments and begun:
            notes.append("event trees are solved without phases: house events as they are defined")
        if figure is not None and not wanted and not begun:
            chosen(model.tops, figure, self.name)
        if begun and not (figure and wanted):
            if importance:
                notes.append("importance is that of the tops, not of the event trees")
            from tracerisk.prm.other_models.logic.event_trees import solved_event_trees

            event_trees = solved_event_trees(model, time)
            data["event_trees"] = [
                {**asdict(item), "outcomes": item.outcomes, "total": item.total}
                for item in event_trees
            ]
            for item in event_trees:
                notes += item.findings
                shown.append((render_event_tree, (item,)))
                figures |= {
                    name if name not in figures else f"{item.event_tree}.{name}": p
                    for name, p in item.outcomes.items()
                }
            if figure is not None:
                figures = {name: figures[name] for name in chosen(figures, figure, self.name)}
        return Solved(figures, data, tuple(shown), tuple(notes), risks)

    def _phases(self, wanted: tuple[str, ...], time: float) -> list[dict[str, Any]]:
        """Solve the tops in each phase of each alignment, for its share of the mission."""
        phases: list[dict[str, Any]] = []
        for alignment in self.model.alignments:
            for phase in alignment.phases:
                model = self.model.in_phase(alignment.name, phase.name)
                spent = phase.fraction * time
                tops = {}
                for top in wanted:
                    tree = model.fault_tree(top, mission_time_h=spent)
                    tops[top] = tuple(tree.probability(tree.values_at(spent)))
                name = f"{alignment.name}, {phase.name}"
                phases.append({"name": name, "fraction": phase.fraction, "tops": tops})
        return phases

    def _in_any_phase(
        self, alignment: Alignment, wanted: tuple[str, ...], time: float, notes: list[str]
    ) -> dict[str, tuple[float, float]]:
        """Solve the tops for phases that follow one another; `notes` get why not."""
        from tracerisk.prm.other_models.logic.phased import phased_probability

        tops: dict[str, tuple[float, float]] = {}
        for top in wanted:
            try:
                tops[top] = phased_probability(self.model, alignment, top, time)
            except ModelError as error:
                notes.append(f"{top} in {alignment.name}, any phase: {error}")
        return tops

    def at(self, mission_time_h: float) -> LogicFile:
        """Return the model with another mission time."""
        return replace(self, mission_time_h=mission_time_h)

    def spread(self, figure: str | None, samples: int, seed: int) -> Uncertainty:
        """Return the uncertainty of a top: the one that is asked for, or the only one."""
        from tracerisk.prm.other_models.logic.set_figures import propagate

        names = self.model.tops if figure is None else self._gate(figure)
        if len(names) != 1:
            raise InputError(
                f"'{self.name}' has {len(names)} tops; say with --figure which --uncertainty is of"
            )
        return propagate(self.model, names[0], self._time(), samples=samples, seed=seed, note=note)

    def _gate(self, figure: str) -> tuple[str, ...]:
        """Return a gate that is asked for by name; raise InputError for an unknown one."""
        if figure in self.model.gates_by_name:
            return (figure,)
        return chosen(self.model.tops, figure, self.name)

    def _time(self) -> float:
        if self.mission_time_h is None and needs_mission_time(self.model):
            raise no_mission_time(self.name)
        return self.mission_time_h or 0.0


def _tops_data(tops: Mapping[str, tuple[float, float]]) -> list[dict[str, Any]]:
    return [{"name": top, "probability": p, "complement": q} for top, (p, q) in tops.items()]
