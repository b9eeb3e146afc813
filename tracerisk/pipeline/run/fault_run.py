"""Run a controller without a fault and once more with faults, and compare the two."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from tracerisk.common.traced.findings import NOTES, REPORTED, Finding
from tracerisk.common.verdict import Reason
from tracerisk.config import Settings
from tracerisk.pipeline.robot.scenario_settings import with_scenario
from tracerisk.pipeline.run.attempts import trace_attempts
from tracerisk.pipeline.run.controller_run import run_again
from tracerisk.pipeline.run.ended_run import PLAIN, ControllerRun, RunOptions
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.trace import Trace
from tracerisk.twin.faults.fault import Fault, check_faults
from tracerisk.twin.robots.robot import Robot

_MESSAGES = frozenset({"joint_trajectory"})
"""The kinds of commands that are messages: nobody answers whether they came to their goal."""


@dataclass(frozen=True, slots=True)
class FaultRun:
    """A run with faults, beside the same run without."""

    faults: tuple[Fault, ...]
    """The faults in the order of their instants."""
    nominal: Trace
    """The trace of the run without faults."""
    trace: Trace
    """The trace of the run with faults."""

    @property
    def words(self) -> str:
        """The faults in words: `panda_joint4 dead at 3.500 s`."""
        return ", ".join(fault.words for fault in self.faults)

    @property
    def reported(self) -> tuple[Finding, ...]:
        """The failures reported to the controller, beyond those without the faults."""
        return new_reports(self.nominal, self.trace, self.faults[0].time_s)

    @property
    def other_findings(self) -> tuple[Finding, ...]:
        """The other findings that the faults add: contacts, errors of callbacks."""
        return tuple(
            finding
            for finding in _more_findings(self.nominal, self.trace, self.faults[0].time_s)
            if finding.kind not in NOTES and finding not in self.reported
        )

    @property
    def other_reasons(self) -> tuple[Reason, ...]:
        """The other reasons that the faults add to the verdict: things that fell."""
        before = _reasons(self.nominal)
        known = {finding.message for finding in self.trace.findings}
        return tuple(
            reason
            for reason in _reasons(self.trace)
            if reason not in before
            and not reason.code.startswith("run-")
            and reason.words not in known
        )

    def after_s(self, finding: Finding) -> float:
        """Return how long after the first fault a finding came [s]."""
        return (finding.time_s or 0.0) - self.faults[0].time_s


def new_reports(nominal: Trace, trace: Trace, fault_s: float) -> tuple[Finding, ...]:
    """Return the failures reported to the controller after the fault [s], not in the run without"""
    unanswered = {
        (command.function.file, command.line)
        for command in trace.commands
        if command.kind in _MESSAGES
    }
    return tuple(
        finding
        for finding in _more_findings(nominal, trace, fault_s)
        if finding.kind in REPORTED
        and not (
            finding.kind == "execution_failure"
            and finding.location is not None
            and (finding.location.file, finding.location.line) in unanswered
        )
    )


def _more_findings(nominal: Trace, trace: Trace, fault_s: float) -> Iterator[Finding]:
    before = {_key_of(finding) for finding in nominal.findings}
    return (
        finding
        for finding in trace.findings
        if (finding.time_s or 0.0) >= fault_s and _key_of(finding) not in before
    )


def nominal_run(
    controller: Controller, settings: Settings, options: RunOptions = PLAIN
) -> ControllerRun:
    """Run a controller without a fault, as `trace_attempts`, and return the run it chose.

    Nothing is drafted for it: a run with a fault must differ from it by the fault alone.
    """
    runs: list[ControllerRun] = []
    trace = trace_attempts(controller, settings, replace(options, on_run=runs.append))
    return next(run for run in runs if run.trace is trace)


def run_with_faults(
    controller: Controller,
    settings: Settings,
    nominal: ControllerRun,
    faults: Sequence[Fault],
    options: RunOptions = PLAIN,
) -> FaultRun:
    """Run a controller once more as in its nominal run, but that units of its robot fail.

    Raises InputError for a unit or mode that the robot does not have, and for an instant that the
    nominal run does not reach.
    """
    checked = check_faults(faults, nominal.robot, before_s=nominal.trace.end.simulated_s)
    done = run_again(controller, nominal, with_scenario(settings), checked, options)
    return FaultRun(checked, nominal.trace, with_faults_named(done.trace, checked, nominal.robot))


def with_faults_named(trace: Trace, faults: Sequence[Fault], robot: Robot) -> Trace:
    """Return the trace of a run with faults that names them, and what is assumed of the drives."""
    lines = [f"fault: {fault.words}, as asked for" for fault in faults]
    blind = [fault for fault in faults if fault.mode in ("frozen", "absent")]
    if any(fault.unit in robot.encoders for fault in blind) and not robot.drives.source:
        lines.append(
            f"the drives of {robot.name} go by an encoder that fails and run away: the robot's "
            "file gives no `drives`"
        )
    return replace(trace, assumptions=(*lines, *trace.assumptions))


def _reasons(trace: Trace) -> tuple[Reason, ...]:
    return () if trace.verdict is None else trace.verdict.reasons


def _key_of(finding: Finding) -> tuple[object, ...]:
    """Return what distinguishes a finding from others, whenever it happened."""
    return finding.kind, finding.function, finding.object, finding.message, finding.location
