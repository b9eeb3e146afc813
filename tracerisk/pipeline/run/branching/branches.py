"""Run a controller once and branch it before each fault, in the place of one run for each."""

from __future__ import annotations

import contextlib
import shutil
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from tracerisk.common import dependencies
from tracerisk.config import Settings
from tracerisk.errors import InputError, MachineError, TraceRiskError
from tracerisk.instrument.recording import Recording
from tracerisk.pipeline.robot.scenario_settings import with_scenario
from tracerisk.pipeline.run.branching.watch import BranchWatch
from tracerisk.pipeline.run.controller_run import run_again, run_request
from tracerisk.pipeline.run.ended_run import ControllerRun, ProcessEnd, RunOptions, ended_run
from tracerisk.pipeline.run.fault_run import FaultRun, with_faults_named
from tracerisk.pipeline.run.run_folders import keep_recording, run_folders
from tracerisk.pipeline.trace.run_files import Branch, BranchPlan, RunRequest, claimed
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.trace import Trace
from tracerisk.twin.faults.fault import check_faults

__all__ = ["Branch", "BranchResult", "run_branches"]

_TRUNK = RunOptions(quiet=True)


@dataclass(frozen=True, slots=True)
class BranchResult:
    """What a branch showed: what a run with its faults from the beginning shows."""

    branch: Branch
    """The branch with its faults."""
    nominal: Trace
    """The trace of the run without faults."""
    done: ControllerRun | None
    """The run of the branch; `None` where it left nothing to read."""
    is_branched: bool
    """Whether it was branched off; false where it ran from the beginning."""
    reason: str = ""
    """Why it was not branched off, in words; empty where it was."""
    error: Exception | None = None
    """Why there is nothing to read; `None` where `done` is there."""

    @property
    def run(self) -> FaultRun:
        """The run beside that without faults. Raises `error` where nothing is to read."""
        if self.done is None:
            raise self.error or InputError("the run left nothing to read")
        trace = with_faults_named(self.done.trace, self.branch.faults, self.done.robot)
        return FaultRun(self.branch.faults, self.nominal, trace)


def run_branches(
    controller: Controller,
    settings: Settings,
    nominal: ControllerRun,
    branches: Sequence[Branch],
    *,
    at_once: int = 1,
    keep: Path | None = None,
    beside: Recording | None = None,
    claims: str = "",
) -> Iterator[BranchResult]:
    """Run a controller once more, and from it the branches; return the result of each, in order.

    At most `at_once` branches run at any time, or are read after their end. `claims` is a folder
    that several calls with the same branches share, in different processes: each branch is that of
    the first call that comes to it, and the others return nothing of it. `keep` is a folder for
    the recordings, one for each branch with its index for a name. The traces of branches are to be
    judged `beside` another run, where one is given, as `make_trace` says. Where the request of
    `nominal` has a run `beside`, branches end once their fate is decided. A branch that cannot
    leave the run, or dies, runs from the beginning on threads; so do all where the run on
    greenlets is not that of `nominal`.
    Raises InputError for a unit or mode that the robot does not have, for an instant that the
    nominal run does not reach, and for an index given twice; MachineError where the machine lacks
    disk or memory.
    """
    before_s = nominal.trace.end.simulated_s
    wanted = [
        replace(branch, faults=check_faults(branch.faults, nominal.robot, before_s=before_s))
        for branch in branches
    ]
    if len({branch.index for branch in wanted}) < len(wanted):
        raise InputError("two branches have the same index")
    if at_once < 1:
        raise InputError(f"{at_once} branches at once are none; expected 1 or more")
    options = RunOptions(keep, quiet=True, beside=beside)
    branching = _Branching(controller, with_scenario(settings), nominal, tuple(wanted), options)
    return branching.results(at_once, claims)


def _cannot_branch() -> str:
    """Return why no run can be branched here, in words; empty where one can."""
    if sys.platform != "linux":
        return "runs are branched on Linux alone"
    if not dependencies.is_installed("greenlet"):
        return "the package greenlet is not installed"
    return ""


@dataclass(slots=True)
class _Found:
    """What became of branches, by their index."""

    reason: str = ""
    """Why no branch of the run counts; empty where they do."""
    left: frozenset[int] = frozenset()
    """The branches that left the run, or were refused to."""
    done: dict[int, ControllerRun] = field(default_factory=dict)
    """The runs of the branches that ended."""
    reasons: dict[int, str] = field(default_factory=dict)
    """Why other branches have no run, in words."""


@dataclass(frozen=True, slots=True)
class _Branching:
    """A run that is to branch, and what its branches are run with."""

    controller: Controller
    """The controller to run."""
    settings: Settings
    """The settings of the run, with its scenario."""
    nominal: ControllerRun
    """The run without faults."""
    branches: tuple[Branch, ...]
    """The branches, in the order of their results."""
    options: RunOptions
    """How the runs are recorded and judged."""

    def results(self, at_once: int, claims: str) -> Iterator[BranchResult]:
        result = _Found(_cannot_branch())
        if not result.reason and self.branches:
            result = self._branched(at_once, claims)
        for branch in self.branches:
            done, error = result.done.pop(branch.index, None), None
            is_ours = done is not None or branch.index in result.left
            if claims and not is_ours and not claimed(claims, branch.index):
                continue
            reason = "" if done else result.reason or result.reasons.get(branch.index, "")
            if done is None:
                options = replace(self.options, keep=self._kept(branch.index))
                try:
                    done = run_again(
                        self.controller, self.nominal, self.settings, branch.faults, options
                    )
                except MachineError:
                    raise
                except (TraceRiskError, RuntimeError) as raised:
                    error = raised
            yield BranchResult(branch, self.nominal.trace, done, not reason, reason, error)

    def _kept(self, index: int) -> Path | None:
        return None if self.options.keep is None else self.options.keep / str(index)

    def _branched(self, at_once: int, claims: str) -> _Found:
        result = _Found()
        nominal, settings = self.nominal, self.settings
        faults = {item.index: item.faults for item in self.branches}

        def ended(index: int, request: RunRequest, end: ProcessEnd) -> None:
            folder = Path(request.folder)
            try:
                done = ended_run(
                    self.controller, nominal.robot, settings, request, end, self.options
                )
                if done.trace.end.cause == "died":
                    result.reasons[index] = f"its branch died: {done.trace.end.message}"
                    return
                kept = self._kept(index)
                if kept is not None:
                    kept.mkdir(parents=True, exist_ok=True)
                    keep_recording(folder, kept)
            except MachineError:
                raise
            except (TraceRiskError, RuntimeError, OSError) as error:
                result.reasons[index] = f"its branch left nothing to read: {error}"
                return
            finally:
                # The run sees by the name that it may go on.
                over = folder.parent.with_suffix(".over")
                with contextlib.suppress(OSError):
                    folder.parent.rename(over)
                shutil.rmtree(over, ignore_errors=True)
            asked = replace(nominal.request, faults=faults[index])
            result.done[index] = replace(done, request=asked)

        watch = BranchWatch(ended)
        with run_folders(None) as (folder, written):
            top = str(folder.parent / "branches")
            plan = BranchPlan(top, self.branches, at_once, settings.cpu_limit_s, claims)
            for name in plan.writable:
                Path(name).mkdir(parents=True, exist_ok=True)
            request = replace(nominal.request, folder=str(folder), greenlets=True, plan=plan)
            try:
                trunk = run_request(
                    self.controller, nominal.robot, settings, request, written, _TRUNK, watch
                )
            except MachineError:
                raise
            except (TraceRiskError, RuntimeError) as error:
                left = frozenset({*watch.left, *watch.refused})
                return _Found(f"the run on greenlets left nothing to read: {error}", left)
        result.left = frozenset({*watch.left, *watch.refused})
        if replace(trunk.trace, inputs=()) != replace(nominal.trace, inputs=()):
            # The files that its robot was chosen by are those of the first run alone.
            return _Found(
                f"on greenlets the run is another: {trunk.trace.end.message}", result.left
            )
        result.reasons |= watch.refused
        for branch in self.branches:
            if branch.index not in result.done:
                result.reasons.setdefault(branch.index, "the run ended before it")
        return result
