"""Fault trees of Galileo that are the phases of one mission, as `solve` takes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import TYPE_CHECKING

from tracerisk.cli.solving.dynamic import DynamicFile
from tracerisk.cli.solving.solved import Solved, chosen
from tracerisk.errors import InputError, one_of
from tracerisk.prm.other_models.dynamic.first_failure import MissionPhase
from tracerisk.prm.other_models.dynamic.phases import mission_probability
from tracerisk.report.model_files import render_tops

if TYPE_CHECKING:
    from tracerisk.prm.questions.uncertainty import Uncertainty

MISSION = "any phase"
"""The figure of the mission."""


@dataclass(frozen=True, slots=True)
class PhaseFiles:
    """Galileo files, each a phase; events of one name are one unit, which stays failed."""

    files: tuple[str, ...]
    """The names of the files, in the order of the phases."""
    trees: tuple[DynamicFile, ...]
    """The tree of each phase."""
    hours: tuple[float, ...]
    """How long each phase lasts [h]."""

    @property
    def name(self) -> str:
        """The name of the figure."""
        return MISSION

    def with_values(self, values: Mapping[str, float]) -> PhaseFiles:
        """Return the trees with parameters, rates or probabilities set in all that have them."""
        trees = list(self.trees)
        for name, value in values.items():
            for number in self._having(name):
                trees[number] = trees[number].with_values({name: value})
        return replace(self, trees=tuple(trees))

    def value_of(self, name: str) -> float:
        """Return the value that the first phase with a parameter or event has for it."""
        return self.trees[self._having(name)[0]].value_of(name)

    def solve(self, figure: str | None, *, importance: bool) -> Solved:
        """Solve the mission."""
        if importance:
            raise InputError(
                "--importance goes with one tree; --phase-hours gives a mission of several"
            )
        chosen((MISSION,), figure, MISSION)
        ends = list(accumulate(self.hours))
        phases = []
        for file, given, begin_h, end_h in zip(
            self.files, self.trees, [0.0, *ends], ends, strict=False
        ):
            tree = given.tree.static_tree()
            phases.append(MissionPhase(file, tree, begin_h, end_h, tree.events))
        pair = mission_probability(MISSION, phases)
        data = {
            "phases": [
                {"name": phase.name, "begin_h": phase.begin_h, "end_h": phase.end_h}
                for phase in phases
            ],
            "tops": [{"name": MISSION, "probability": pair.p, "complement": pair.q}],
        }
        shown = ((render_tops, (" -> ".join(self.files), {MISSION: pair})),)
        return Solved({MISSION: pair.p}, data, shown, risks=(MISSION,))

    def at(self, mission_time_h: float) -> PhaseFiles:  # noqa: ARG002
        """Raise InputError: each phase has its own time."""
        raise InputError("--curve goes with --mission-time; --phase-hours gives each phase its own")

    def spread(self, figure: str | None, samples: int, seed: int) -> Uncertainty:
        """Raise InputError: Galileo has no distributions."""
        return self.trees[0].spread(figure, samples, seed)

    def _having(self, name: str) -> list[int]:
        """Return the numbers of the phases that have a parameter or an event."""
        having = [number for number, given in enumerate(self.trees) if name in _names(given)]
        if not having:
            known = sorted({known for given in self.trees for known in _names(given)})
            raise InputError(f"there is no event '{name}'; {one_of(known, name)}")
        return having


def _names(given: DynamicFile) -> set[str]:
    return {*given.parameters, *(event.name for event in given.tree.events)}


def phase_files(
    files: tuple[str, ...], hours: tuple[float, ...], read: Callable[[str], DynamicFile]
) -> PhaseFiles:
    """Return Galileo files as the phases of a mission, each for its hours.

    Raises InputError where the numbers of files and of phases differ, and as `read` does.
    """
    if len(files) != len(hours):
        raise InputError(
            f"--phase-hours gives {len(hours)} times, and there are {len(files)} files; give one "
            "time for each file, as --phase-hours 0.5,8"
        )
    return PhaseFiles(files, tuple(map(read, files)), hours)
