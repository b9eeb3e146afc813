"""Run the cells of a campaign, a batch at a time, in whatever process an executor has."""

from __future__ import annotations

import atexit
import contextlib
import io
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from tracerisk.config import Settings
from tracerisk.errors import InputError, LogError
from tracerisk.evidence.cells import Cell
from tracerisk.hardware.model import FaultMode
from tracerisk.instrument.recording import read_recording
from tracerisk.pipeline.evidence.judgement import judge
from tracerisk.pipeline.evidence.mission_run import MissionRun, mission_run
from tracerisk.pipeline.run.branching.branches import Branch, run_branches
from tracerisk.pipeline.run.controller_run import ControllerRun
from tracerisk.pipeline.run.fault_run import nominal_run
from tracerisk.pipeline.trace.run_files import EVENTS, GRAPH_USE
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.ros.scenario.success import Condition
from tracerisk.twin.faults.fault import Fault
from tracerisk.twin.recording.samples import Samples, has_samples, read_samples

if TYPE_CHECKING:
    from tracerisk.trace import Trace

_MORE_SHARE, _MORE_S = 2.0, 30.0
"""A run with a failure may take this much of the time of the run without, and more [s]."""


@dataclass(frozen=True, slots=True)
class CellBatch:
    """Some cells of a campaign, with all that a process needs to run them.

    `options` are the settings that go before those of `pyproject.toml`, as plain values. `digest`
    is that of the run without a failure: a machine on which that differs is no use.
    """

    controller: str
    options: tuple[tuple[str, Any], ...]
    digest: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Nominal:
    """The run without a failure, as cells are compared with it."""

    controller: Controller
    settings: Settings
    run: ControllerRun
    folder: Path
    mission: MissionRun
    samples: Samples | None
    success: tuple[Condition, ...]

    @property
    def trace(self) -> Trace:
        """The trace of the run."""
        return self.run.trace


@dataclass(frozen=True, slots=True)
class BatchDone:
    """The cells of a batch, judged, in their order.

    `whole_runs` says in words why cells were run from the beginning, where they were not branched
    off one run.
    """

    cells: tuple[Cell, ...]
    whole_runs: tuple[str, ...] = ()


def run_batch(batch: CellBatch) -> BatchDone:
    """Run the cells of a batch, branched off one run, and judge them.

    The run without a failure is made once in each process. Raises InputError where it is not
    that of the campaign.
    """
    nominal = nominal_of(batch.controller, batch.options)
    if trace_digest(nominal.trace) != batch.digest:
        raise InputError(
            f"the run of {batch.controller} without a failure differs from that of the campaign: "
            "the sources, the settings or the machine's libraries are not the same"
        )
    request = replace(nominal.run.request, duration_s=_duration_s(nominal))
    before = replace(nominal.run, request=request)
    folder = Path(tempfile.mkdtemp(prefix="tracerisk-cells-"))
    branches = [
        Branch(index, (Fault(cell.unit, cast(FaultMode, cell.mode), cell.time_s),), cell.time_s)
        for index, cell in enumerate(batch.cells)
    ]
    cells, reasons = [], []
    try:
        for result in run_branches(
            nominal.controller,
            nominal.settings,
            before,
            branches,
            keep=folder,
            with_exposures=False,
        ):
            cell = batch.cells[result.branch.index]
            kept = folder / str(result.branch.index)
            cells.append(_judged(nominal, cell, result.done, result.error, kept))
            shutil.rmtree(kept, ignore_errors=True)
            reasons += [] if result.is_branched else [result.reason]
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return BatchDone(tuple(cells), tuple(dict.fromkeys(reasons)))


def trace_digest(trace: Trace) -> str:
    """Return a digest of all that a trace says."""
    import hashlib

    from tracerisk import trace_json

    return hashlib.sha256(trace_json.dumps(trace).encode()).hexdigest()


@lru_cache(maxsize=4)
def nominal_of(controller: str, options: tuple[tuple[str, Any], ...]) -> Nominal:
    """Run a controller without a failure, once in this process, and keep what it left.

    Raises as `trace_controller`.
    """
    from tracerisk.pipeline.stages import load_hardware, load_settings

    folder = Path(tempfile.mkdtemp(prefix="tracerisk-evidence-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    loaded = load_controller(controller)
    settings = load_settings(loaded, dict(options))
    with contextlib.redirect_stderr(io.StringIO()):
        # What the controller prints was seen in its own run.
        run = nominal_run(loaded, settings, hardware_of=load_hardware, keep=folder)
    mission = mission_run(run.trace, folder, called=_called(folder))
    samples = read_samples(folder) if has_samples(folder) else None
    return Nominal(loaded, settings, run, folder, mission, samples, declared_success(settings))


def declared_success(settings: Settings) -> tuple[Condition, ...]:
    """Return what the scenario of the settings says a mission is; empty where it does not."""
    if settings.scenario is None:
        return ()
    from tracerisk.ros.scenario.scenario import read_scenario

    return read_scenario(Path(settings.scenario)).success


def _judged(
    nominal: Nominal,
    cell: Cell,
    done: ControllerRun | None,
    error: Exception | None,
    folder: Path,
) -> Cell:
    """Return a cell with what became of its run, whose recording is in the folder."""
    if done is not None:
        try:
            failed = mission_run(
                done.trace,
                folder,
                unit=cell.unit,
                fault_s=cell.time_s,
                nominal=nominal.samples,
                called=_called(folder),
            )
            return judge(nominal.mission, failed, cell, nominal.success)
        except LogError as damaged:
            error = damaged
    # The run without a failure left a recording: what this one lacks is the failure's doing.
    lost = (f"no recording of the run: {error}",)
    return replace(cell, fails=True, effect="ended_badly", lost=lost)


def _duration_s(nominal: Nominal) -> float:
    """Return how long a run with a failure may take [s]: one that never ends has failed."""
    asked = nominal.run.request.duration_s
    if nominal.trace.end.cause == "duration":
        return asked
    return min(asked, _MORE_SHARE * (nominal.trace.end.simulated_s or asked) + _MORE_S)


def _called(folder: Path) -> Mapping[str, int]:
    """Return how many messages and calls a run sent to each name of the graph."""
    if not (folder / EVENTS).exists():
        return {}
    note = read_recording(folder / EVENTS).note(GRAPH_USE)
    return {} if note is None else {str(k): int(v) for k, v in note["counts"].items()}


def batches(
    cells: Sequence[Cell],
    controller: str,
    options: tuple[tuple[str, Any], ...],
    digest: str,
    size: int,
) -> list[CellBatch]:
    """Return the cells in batches of a size."""
    return [
        CellBatch(controller, options, digest, tuple(cells[at : at + size]))
        for at in range(0, len(cells), size)
    ]
