"""Run the cells of a campaign, a batch at a time, in whatever process an executor has."""

from __future__ import annotations

import contextlib
import hashlib
import io
import pickle
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.common import trace_json
from tracerisk.common.evidence.cells import Cell, Effect
from tracerisk.common.evidence.file import cell_line
from tracerisk.common.sandbox.scratch import new_scratch, scratch
from tracerisk.common.traced.findings import REPORTED
from tracerisk.config import Settings
from tracerisk.errors import ControllerFailedError, InputError, LogError
from tracerisk.instrument.recording import Recording, read_recording
from tracerisk.pipeline.evidence.journal import keep_lines
from tracerisk.pipeline.evidence.judgement import judge
from tracerisk.pipeline.evidence.mission_run import MissionRun, mission_run
from tracerisk.pipeline.evidence.workers import is_ending
from tracerisk.pipeline.freshness.evidence_lines import at_bare_line
from tracerisk.pipeline.run.branching.branches import Branch, run_branches
from tracerisk.pipeline.run.branching.flow import key_of
from tracerisk.pipeline.run.controller_run import run_again
from tracerisk.pipeline.run.ended_run import ControllerRun, RunOptions
from tracerisk.pipeline.run.fault_run import nominal_run
from tracerisk.pipeline.trace.run_files import DECIDED, EVENTS, RunBeside
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.success import Condition
from tracerisk.twin.faults.fault import Fault, fault_named
from tracerisk.twin.recording.samples import Samples

if TYPE_CHECKING:
    from tracerisk.trace import Trace

_KEPT = "nominal.pickle"
_MORE_SHARE, _MORE_S = 2.0, 30.0
"""A run with a failure may take this much of the time of the run without, and more [s]."""


@dataclass(frozen=True, slots=True)
class CellBatch:
    """Some cells of a campaign, with all that a process needs to run them."""

    controller: str
    """The path of the controller."""
    options: tuple[tuple[str, Any], ...]
    """The settings that go before those of `pyproject.toml`, as (name, plain value)."""
    digest: str
    """The digest of the run without a failure, which the machine must reproduce."""
    cells: tuple[Cell, ...]
    """The failures to try."""
    folder: str = ""
    """The folder on this machine with the run without a failure; empty where each process makes
    the run itself."""
    claims: str = ""
    """The folder in which batches of the same cells claim them, first come first served; empty
    where no batch shares cells."""
    journal: str = ""
    """The file on this machine that keeps each cell as soon as it is judged; empty where the
    campaign keeps those of a batch."""


@dataclass(frozen=True, slots=True, eq=False)
class Nominal:
    """The run without a failure, as cells are compared with it."""

    controller: Controller
    """The controller that ran."""
    settings: Settings
    """The settings of the run."""
    run: ControllerRun
    """The run with its trace and request."""
    folder: Path
    """The folder of its recording."""
    digest: str
    """That of all that its trace says."""
    mission: MissionRun
    """The outcome of the mission, as `judge` compares it."""
    success: tuple[Condition, ...]
    """The conditions of `success` in the scenario; empty for none."""

    @property
    def recording(self) -> Recording:
        """The recorded calls, commands and findings."""
        return self.mission.recording

    @property
    def samples(self) -> Samples | None:
        """The samples of the run; `None` where none were recorded."""
        return self.mission.samples

    @property
    def beside(self) -> RunBeside:
        """What of the run shows, while another goes on, that a mission has failed."""
        reports = {
            (finding.kind, finding.message, finding.object)
            for finding in self.recording.findings
            if finding.kind in REPORTED
        }
        log = None if self.samples is None else self.samples.contacts
        touches = set()
        if log is not None:
            pairs = np.unique(log.rows[["one", "two"]])
            touches = {
                (log.bodies[min(one, two)].name, log.bodies[max(one, two)].name)
                for one, two in pairs.tolist()
            }
        first = {command.issue_ns: command.id for command in reversed(self.recording.commands)}
        begins = (round(visit.start_s * 1e9) for visit in self.trace.visits[1:])
        arrivals = [
            (first[begin], tuple(at.values()))
            for begin, at in zip(begins, self.mission.arrivals, strict=False)
            if begin in first
        ]
        return RunBeside(
            tuple(sorted(reports)),
            tuple(sorted(touches)),
            tuple(arrivals),
            tuple(map(key_of, self.recording.commands)),
            bool(self.success),
        )

    @property
    def trace(self) -> Trace:
        """The trace of the run."""
        return self.run.trace


@dataclass(frozen=True, slots=True)
class BatchDone:
    """The judged cells of a batch."""

    cells: tuple[Cell, ...]
    """The cells in their order; where batches share cells, only those that this one claimed."""
    whole_runs: tuple[str, ...] = ()
    """Why cells were run from the beginning instead of branched off one run, in words."""


def run_batch(batch: CellBatch) -> BatchDone:
    """Run the cells of a batch, branched off one run, and judge them.

    The run without a failure is that which the campaign has kept, or is made once in each
    process. Raises InputError where it is not that of the campaign.
    """
    nominal = nominal_again(batch.controller, batch.options, batch.digest, batch.folder)
    cells: dict[int, Cell | None] = {}
    reasons: list[str] = []
    todo: Sequence[int] = range(len(batch.cells))
    if batch.claims and sum(1 for _ in Path(batch.claims).iterdir()) >= len(todo):
        return BatchDone(())
    # What a run that was ended early does not show, one shows that goes on.
    for beside, claims in ((nominal.beside, batch.claims), (None, "")):
        for index, judged, reason in _run(nominal, batch.cells, todo, beside, claims):
            if is_ending():
                return BatchDone(())
            cells[index] = judged
            reasons += [reason] if reason else []
            if judged is not None and batch.journal:
                keep_lines(Path(batch.journal), [cell_line(judged)])
        todo = [index for index, judged in cells.items() if judged is None]
    done = tuple(judged for _, judged in sorted(cells.items()) if judged is not None)
    return BatchDone(done, tuple(dict.fromkeys(reasons)))


def _run(
    nominal: Nominal,
    cells: Sequence[Cell],
    todo: Sequence[int],
    beside: RunBeside | None,
    claims: str,
) -> Iterator[tuple[int, Cell | None, str]]:
    """Run cells; yield the number of each that no other claims, judged, and why it did not branch.

    It is `None` where the run was ended `beside` that without a failure, and does not show that
    the mission has failed.
    """
    request = replace(nominal.run.request, duration_s=longest_s(nominal), beside=beside)
    branches = [
        Branch(index, (fault_of(cell),), cell.time_s)
        for index, cell in ((index, cells[index]) for index in todo)
    ]
    with scratch("cells-") as folder:
        for result in run_branches(
            nominal.controller,
            nominal.settings,
            replace(nominal.run, request=request),
            branches,
            keep=folder,
            beside=nominal.recording,
            claims=claims,
        ):
            kept = folder / str(result.branch.index)
            cell = cells[result.branch.index]
            judged = _judged(nominal, cell, result.done, result.error, kept)
            yield result.branch.index, judged, "" if result.is_branched else result.reason
            shutil.rmtree(kept, ignore_errors=True)


def whole_run(nominal: Nominal, cell: Cell, folder: Path) -> Cell:
    """Run a cell from the beginning to its end, on threads, and return it judged.

    The recording goes into `folder`. This is what `run_batch` is measured against.
    """
    fault = fault_of(cell)
    request = replace(nominal.run.request, duration_s=longest_s(nominal))
    before = replace(nominal.run, request=request)
    options = RunOptions(folder, quiet=True)
    done = run_again(nominal.controller, before, nominal.settings, (fault,), options)
    judged = _judged(nominal, cell, done, None, folder)
    assert judged is not None, "it was followed to its end"
    return judged


def fault_of(cell: Cell) -> Fault:
    """Return the failure of a cell."""
    return fault_named(cell.unit, cell.mode, cell.time_s)


def nominal_again(
    controller: str, options: tuple[tuple[str, Any], ...], digest: str, folder: str
) -> Nominal:
    """Return the run without a failure of a campaign: the one that is kept, or another.

    Raises InputError where that is not the same by its digest.
    """
    nominal = _kept(folder) or nominal_of(controller, options)
    if nominal.digest != digest:
        raise InputError(
            f"the run of {controller} without a failure differs from that of the campaign: "
            "the sources, the settings or the machine's libraries are not the same"
        )
    return nominal


@lru_cache(maxsize=4)
def nominal_of(controller: str, options: tuple[tuple[str, Any], ...]) -> Nominal:
    """Run a controller without a failure, once in this process, and keep what it left.

    Raises as `trace_controller`.
    """
    folder = new_scratch("evidence-")
    loaded = load_controller(controller)
    settings = loaded.settings_with(dict(options))
    with contextlib.redirect_stderr(io.StringIO()):
        # What the controller prints was seen in its own run.
        run = nominal_run(loaded, settings, RunOptions(folder))
    with (folder / _KEPT).open("wb") as kept:
        _Pickler(kept).dump((loaded, settings, run))
    return _nominal(loaded, settings, run, folder)


def nominal_mission(controller: str, options: tuple[tuple[str, Any], ...], purpose: str) -> Nominal:
    """Return the run of a controller without a failure, where there is a mission in it.

    `purpose` is what it is for: `fail`. Raises as `nominal_of`, and ControllerFailedError where
    the run came to a bad end or commanded nothing.
    """
    nominal = nominal_of(controller, options)
    trace = nominal.trace
    if not trace.is_usable or not trace.functions:
        is_idle = trace.end.is_good and not trace.functions
        message = "it commanded no hardware" if is_idle else trace.end.message
        raise ControllerFailedError(
            f"there is no mission to {purpose}: {message}", trace.end.location, trace.end.scenario
        )
    return nominal


class _Pickler(pickle.Pickler):
    """Writes views of dictionaries too, which a robot is made of."""

    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, MappingProxyType):
            return _view, (dict(value),)
        return NotImplemented


def _view(values: dict[Any, Any]) -> Mapping[Any, Any]:
    return MappingProxyType(values)


@lru_cache(maxsize=4)
def _kept(folder: str) -> Nominal | None:
    """Return the run that the campaign's process has kept in a folder of its own."""
    path = Path(folder, _KEPT)
    if not folder or not path.is_file():
        return None
    with path.open("rb") as kept:
        loaded, settings, run = pickle.load(kept)
    return _nominal(loaded, settings, run, path.parent)


def _nominal(loaded: Controller, settings: Settings, run: ControllerRun, folder: Path) -> Nominal:
    events = folder / EVENTS
    recording = read_recording(events) if events.exists() else Recording()
    mission = mission_run(run.trace, folder, recording)
    digest = hashlib.sha256(trace_json.dumps(run.trace).encode()).hexdigest()
    success = declared_success(settings)
    return Nominal(loaded, settings, run, folder, digest, mission, success)


def declared_success(settings: Settings) -> tuple[Condition, ...]:
    """Return what the scenario of the settings says a mission is; empty where it does not.

    What nobody has confirmed does not count: evidence lowers figures on the user's word alone.
    """
    if settings.scenario is None:
        return ()
    declared = read_scenario(Path(settings.scenario)).success
    return tuple(condition for condition in declared if not condition.is_assumed)


def _judged(
    nominal: Nominal,
    cell: Cell,
    done: ControllerRun | None,
    error: Exception | None,
    folder: Path,
) -> Cell | None:
    """Return a cell with what became of its run, whose recording is in the folder.

    `None` where it was ended early and does not show that the mission has failed.
    """
    if done is not None:
        try:
            recording = read_recording(folder / EVENTS)
            failed = mission_run(
                done.trace,
                folder,
                recording,
                unit=cell.unit,
                fault_s=cell.time_s,
                nominal=nominal.samples,
                is_decided=recording.note(DECIDED) is not None,
            )
            judged = judge(nominal.mission, failed, cell, has_conditions=bool(nominal.success))
            place = at_bare_line(judged.missed_at, nominal.controller)
            judged = replace(judged, missed_at=place)
            return judged if judged.fails or not failed.is_decided else None
        except LogError as damaged:
            error = damaged
    # The run without a failure left a recording: what this one lacks is the failure's doing.
    lost = (f"no recording of the run: {error}",)
    effect: Effect = "ended_badly"
    return replace(cell, fails=True, effect=effect, effects=(effect,), fate="unaware", lost=lost)


def longest_s(nominal: Nominal) -> float:
    """Return how long a run that is compared with this one may take [s]: one may never end."""
    asked = nominal.run.request.duration_s
    if nominal.trace.end.cause == "duration":
        return asked
    return min(asked, _MORE_SHARE * (nominal.trace.end.simulated_s or asked) + _MORE_S)
