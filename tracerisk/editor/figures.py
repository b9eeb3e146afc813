"""The figures of a controller as its blocks have them now, and what its lock keeps of its run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from threading import Lock
from typing import Any

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.verdict import Verdict
from tracerisk.editor.outline import Outline
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.freshness.known_controllers import with_moved
from tracerisk.pipeline.trace.kept_verdict import kept_verdict
from tracerisk.pipeline.trace.last_run import kept_uncovered
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.prm.hybrid.assessment import Assessment, ComponentImportance, StateAssessment
from tracerisk.prm.hybrid.from_blocks import build_model
from tracerisk.prm.hybrid.solve import solve

_KEPT = 32
_ONE_AT_A_TIME = Lock()


@dataclass(frozen=True, slots=True)
class UnitUse:
    """What the most used unit of a component did in a function, over all its visits."""

    unit: str
    """The unit's name, an element of the robot."""
    moving_s: float
    """The time in motion [s]."""
    holding_s: float
    """The time at rest under load [s]."""
    grasping_s: float
    """The time with something grasped [s]."""
    reading_s: float
    """The time in which the controller read it [s]."""

    @property
    def used_s(self) -> float:
        """A time that shows which unit is most in use [s]."""
        return self.moving_s + self.holding_s + self.grasping_s + self.reading_s


@dataclass(frozen=True, slots=True)
class ControllerFigures:
    """A controller with its solved model."""

    controller: Controller
    """The controller that the blocks belong to."""
    names: Mapping[FunctionRef, str] = field(default_factory=dict)
    """The names of its functions in the model."""
    assessment: Assessment | None = None
    """The solution of the model; `None` where there is none."""
    problem: TraceRiskError | None = None
    """Why there is no solution; `None` where there is one."""
    verdict: Verdict | None = None
    """The verdict of the last run, as the lock keeps it; `None` where none is kept."""
    never_ran: tuple[FunctionRef, ...] = ()
    """The functions that can command hardware and did not run."""
    summary: Mapping[str, Any] = field(default_factory=dict)
    """What the lock keeps of the run, as plain data."""
    blocks: tuple[RiskBlock, ...] = ()
    """The risk blocks that the model is made of."""

    @property
    def importances(self) -> tuple[ComponentImportance, ...]:
        """How much the mission hangs on each component; `assessment` itself leaves it out."""
        with _ONE_AT_A_TIME:
            solved = _solved(self.blocks, self.controller.path.name, with_importances=True)
        return solved.components if isinstance(solved, Assessment) else ()

    def state(self, file: str, function: QualifiedName) -> StateAssessment | None:
        """Return the figures of a function of one of the controller's files."""
        name = self.names.get(FunctionRef(file, function))
        states = () if self.assessment is None else self.assessment.states
        return next(
            (state_assessment for state_assessment in states if state_assessment.name == name), None
        )

    def share(self, state: StateAssessment) -> float:
        """Return the share that a function has of the mission's failure probability."""
        assert self.assessment is not None
        whole = self.assessment.mission.geometric_cycles
        return state.absorption_probability / whole if whole > 0.0 else 0.0

    @property
    def ran(self) -> tuple[str, ...]:
        """The functions of the last run, by their names in the model."""
        return tuple(_table(self.summary.get("functions")))

    def run(self, name: str) -> tuple[int, float] | None:
        """Return how often the run visited a function, and how long in all [s]."""
        kept = self._kept(name)
        visits, seconds = kept.get("visits"), kept.get("duration_s")
        if isinstance(visits, int) and isinstance(seconds, int | float):
            return visits, float(seconds)
        return None

    def use(self, name: str, component: str) -> UnitUse | None:
        """Return what the unit of a component that is most in use did in a function's visits.

        `None` where the lock keeps no times of its units, as of a sensor, which is in use as the
        joint is that it sits on.
        """
        kept = self._kept(name)
        units = _table(_table(kept.get("instances")).get(component))
        elements = _table(kept.get("elements"))
        uses = [_use(unit, _table(elements[unit])) for unit in units if unit in elements]
        return max(uses, key=lambda unit_use: unit_use.used_s, default=None)

    def _kept(self, name: str) -> Mapping[str, Any]:
        return _table(_table(self.summary.get("functions")).get(name))


def _table(value: Any) -> Mapping[str, Any]:
    """Return a table of the lock; an empty one for what someone else put there."""
    return value if isinstance(value, Mapping) else {}


def _use(unit: str, kept: Mapping[str, Any]) -> UnitUse:
    def seconds(key: str) -> float:
        value = kept.get(key, 0.0)
        return float(value) if isinstance(value, int | float) else 0.0

    return UnitUse(unit, *map(seconds, ("moving_s", "holding_s", "grasping_s", "reading_s")))


def figures_of(controller: Controller, outline: Callable[[str], Outline]) -> ControllerFigures:
    """Return the figures of a controller; `outline` gives that of one of its files.

    Nothing is simulated. Raises InputError where the lock or a file cannot be read.
    """
    lock = with_moved(controller.project.lock, controller)
    entry = lock.controllers.get(controller.file)
    placed: dict[FunctionRef, RiskBlock] = {}
    problem: TraceRiskError | None = None
    for file in files_of(controller, entry):
        result = outline(file)
        placed |= {
            FunctionRef(file, placed_block.function): placed_block.block
            for placed_block in result.placed
        }
        problem = problem or next(iter(result.problems), None)
    names = model_names(placed)
    assessment = None
    blocks = tuple(replace(block, name=QualifiedName(names[ref])) for ref, block in placed.items())
    if blocks:
        with _ONE_AT_A_TIME:  # who comes second finds it solved
            solved = _solved(blocks, controller.path.name, with_importances=False)
        if isinstance(solved, Assessment):
            assessment = solved
        else:
            problem = problem or solved
    summary = {} if entry is None else entry.trace
    uncovered = tuple(ref for ref in kept_uncovered(summary) if ref not in placed)
    return ControllerFigures(
        controller, names, assessment, problem, kept_verdict(entry), uncovered, summary, blocks
    )


def files_of(controller: Controller, entry: ControllerLock | None) -> tuple[str, ...]:
    """Return the files that hold blocks of a controller, as the lock names them, its own first."""
    others = [] if entry is None else sorted(file for file, held in entry.blocks.items() if held)
    there = [
        file
        for file in others
        if file != controller.file
        and (file in controller.others or controller.path_of(file).is_file())
    ]
    return (controller.file, *there)


@lru_cache(maxsize=_KEPT)
def _solved(
    blocks: tuple[RiskBlock, ...], name: str, *, with_importances: bool
) -> Assessment | TraceRiskError:
    """Return the solved model of blocks; what keeps it from being one, if it is none."""
    try:
        return solve(build_model(blocks, name=name), with_importances=with_importances)
    except TraceRiskError as error:
        return error
