"""Run a controller with one change, and compare the run with the one without."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tracerisk.common.outcome.changes import outcome_changes
from tracerisk.common.outcome.kept import kept_outcome, outcome_summary
from tracerisk.common.outcome.tolerances import TOLERANCES, Tolerances
from tracerisk.common.verdict import MISSED_CALL, MISSION_MISSED, Reason
from tracerisk.config import Settings
from tracerisk.errors import MachineError, TraceRiskError
from tracerisk.pipeline.evidence.cell_runs import Nominal, longest_s, nominal_again
from tracerisk.pipeline.mutation.change import Change
from tracerisk.pipeline.robot.scenario_settings import with_scenario
from tracerisk.pipeline.run.controller_run import run_with_sources
from tracerisk.pipeline.run.ended_run import RunOptions
from tracerisk.report.mutants import MutantRun
from tracerisk.trace import Trace

_MORE_OWN = 3.0
_MORE_OWN_S = 5.0
"""A changed controller may compute or sleep this many times as long, and more [s]."""


@dataclass(frozen=True, slots=True)
class MutantJob:
    """A change to run, with all that a process needs for it."""

    controller: str
    """The path of the controller."""
    options: tuple[tuple[str, Any], ...]
    """The settings that go before those of `pyproject.toml`, as (name, plain value)."""
    digest: str
    """The digest of the run without the change, which the machine must reproduce."""
    folder: str
    """The folder on this machine with the run without the change; empty where each process makes
    the run itself."""
    change: Change
    """The change to the source."""


def run_mutant(job: MutantJob) -> MutantRun:
    """Run a controller with one change, and compare the run with the one without.

    Nothing on disk is changed. Raises InputError where the run without the change is another one.
    """
    nominal = nominal_again(job.controller, job.options, job.digest, job.folder)
    change, sources = job.change, nominal.recording.sources
    changed = {change.file: change.applied(sources[change.file])}
    try:
        done = run_with_sources(
            nominal.run,
            nominal.controller.as_ran(sources),
            _bounded(nominal),
            changed,
            RunOptions(quiet=True),
            duration_s=longest_s(nominal),
        )
    except MachineError:
        raise
    except TraceRiskError as error:
        return _mutant(change, reason=error.message, is_whole=False)
    return compared(change, nominal.trace, done.trace, Tolerances.of(nominal.settings))


def _bounded(nominal: Nominal) -> Settings:
    """Return the settings of a run that may never end, such as a loop whose end was changed."""
    settings = with_scenario(nominal.settings)
    own_s = _MORE_OWN * nominal.run.own_s + _MORE_OWN_S
    return settings.with_options({"stall_limit_s": min(settings.stall_limit_s, own_s)})


def compared(
    change: Change, nominal: Trace, trace: Trace, tolerances: Tolerances = TOLERANCES
) -> MutantRun:
    """Return what a run with a change shows that the one without does not."""
    assert nominal.verdict is not None
    assert trace.verdict is not None
    known = {_key(reason) for reason in nominal.verdict.open_reasons}
    new = [reason for reason in trace.verdict.open_reasons if _key(reason) not in known]
    others = [reason for reason in new if reason.code != MISSION_MISSED]
    return _mutant(
        change,
        verdict=trace.verdict.kind,
        reason=str(next(iter(new), "")),
        differs=differences(nominal, trace, tolerances),
        is_whole=trace.verdict.kind != "stuck",
        success_notices=len(others) < len(new),
        verdict_notices=bool(others),
    )


def _key(reason: Reason) -> tuple[str, ...]:
    """Return what makes a reason another one: of a missed call its function, however written."""
    code, function, thing = reason.key
    return (code, function) if code == MISSED_CALL else (code, function, thing)


def _mutant(change: Change, **found: Any) -> MutantRun:
    return MutantRun(change.file, change.line, change.function, change.kind, change.words, **found)


def differences(
    nominal: Trace, trace: Trace, tolerances: Tolerances = TOLERANCES
) -> tuple[str, ...]:
    """Return what a run brought about that another did not, a sentence each, the gravest first.

    How long the arm rests and moves decides nothing.
    """
    end: tuple[str, ...] = ()
    if trace.end.cause != nominal.end.cause:
        end = (f"the run ends differently: {trace.end.message}",)
    # As `diff` compares them, which has what a lock keeps: long runs are compared in no time.
    old, new = (kept_outcome(outcome_summary(each.outcome)) for each in (nominal, trace))
    if old is None or new is None:
        return end
    return (*outcome_changes(old, new, tolerances).of_mission, *end)
