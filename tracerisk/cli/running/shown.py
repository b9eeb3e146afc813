"""What `tracerisk run` prints of a run."""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.cli.running.finished_run import FinishedRun, keeps_files
from tracerisk.cli.running.in_worlds import print_worlds, worlds_exit, worlds_json
from tracerisk.cli.shared.explain import derivation_json, print_derivation
from tracerisk.cli.shared.output import (
    note,
    paper,
    print_diffs,
    print_json,
    print_text,
    risk_exit,
    terminal_width,
    undetected_exit,
    write_file,
)
from tracerisk.cli.shared.run_report import (
    blocks_line,
    failure_of,
    finding_exit,
    finding_lines,
    headline,
    note_draft,
    note_moved,
    object_lines,
    other_steps,
    print_failure,
    trace_as_typed,
)
from tracerisk.cli.shared.verdict import print_verdict, verdict_exit, verdict_json
from tracerisk.cli.solving.figure_options import print_what_if, what_if_data
from tracerisk.common import trace_json
from tracerisk.common.traced.findings import NOTHING_TO_GRASP
from tracerisk.common.verdict import GAPS
from tracerisk.errors import ExitCode
from tracerisk.report.terminal import render_assessment, render_brief
from tracerisk.trace import Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.assessed import Assessed


def show_failure(options: argparse.Namespace, trace: Trace) -> int:
    """Print how a run ended that ended badly; return the exit code."""
    if options.trace is not None:
        write_file(options.trace, trace_json.dumps(trace))
    code = print_failure(trace_as_typed(trace, options.controller))
    if options.report is not None:
        message = f"{options.report}: no report is written of a run that ended badly"
        kept = "; the file is an earlier one" if Path(options.report).exists() else ""
        note(f"{message}{kept}", quiet=options.quiet)
    if options.json:
        data = trace_json.trace_data(trace)
        verdict = verdict_json(trace.verdict)
        print_json("run", exit_code=code, **verdict, error=failure_of(trace), trace=data)
    return code


def show_run(options: argparse.Namespace, done: FinishedRun) -> int:
    """Print the results of a run, most important first; return the exit code."""
    assessed = done.assessed
    trace, annotated, assessment = assessed.trace, assessed.annotated, assessed.assessment
    typed = trace_as_typed(trace, options.controller)
    note_draft(typed, quiet=options.quiet)
    note_moved(annotated.moved, options.controller, quiet=options.quiet)
    for line in other_steps(annotated):
        note(f"{options.controller}: {line}", quiet=options.quiet)
    risks = {"mission failure": assessment.mission.failure_probability}
    code = max(
        verdict_exit(trace.verdict),
        risk_exit(risks, options.max_failure_probability),
        undetected_exit(assessment.mission, options.max_undetected_probability),
        finding_exit(trace, assessed.settings.fail_on),
        worlds_exit(trace.worlds),
    )
    if options.check and annotated.is_changed:
        code = ExitCode.WOULD_CHANGE
    if options.json:
        from tracerisk.prm.formats import model_json
        from tracerisk.prm.formats.assessment_json import assessment_to_json

        print_json(
            "run",
            exit_code=int(code),
            **verdict_json(trace.verdict),
            **({} if trace.end.is_good else {"error": failure_of(trace)}),
            trace=trace_json.trace_data(trace),
            objects=trace_json.trace_data(trace)["objects"],
            worlds=worlds_json(trace.worlds),
            assessment=assessment_to_json(assessment),
            assumptions=[*typed.assumptions, *annotated.computed.assumptions],
            model=model_json.model_data(assessed.model),
            **derivation_json(done.derivation),
            **done.figures.data(annotated.computed.names),
            **what_if_data([], (), done.uncertainty),
            uncertainty_band=None if done.band is None else asdict(done.band),
        )
        return int(code)
    typed = trace_as_typed(trace, options.controller)
    print_verdict(typed.verdict, options)
    print_worlds(typed.worlds, options)
    if options.diff:
        print_diffs(annotated)
    for line in _notes(options, assessed, typed):
        note(line, quiet=options.quiet)
    if not (options.diff or options.quiet):
        exposures, findings = annotated.computed.exposures_by_name, finding_lines(typed)
        words = [_caution(typed), "" if done.band is None else done.band.words]
        band = " ".join(filter(None, words))
        is_brief = sys.stdout.isatty() and not options.verbose
        following = _following(options, typed, is_brief=is_brief)
        if is_brief:
            text = render_brief(assessment, exposures, findings, following, paper(), band)
        else:
            assumed = (*typed.assumptions, *annotated.computed.assumptions)
            tables = done.figures.tables(terminal_width())
            text = render_assessment(
                assessment, exposures, findings, assumed, tables, paper(), band, following
            )
        print_text(text)
    if not options.diff:
        print_what_if(assessment, [], done.uncertainty, importance=False, pairs=None)
    print_derivation(done.derivation, assessed.model, assessment)
    return int(code)


def _following(options: argparse.Namespace, trace: Trace, *, is_brief: bool) -> list[str]:
    """Return what to do next, a line each."""
    name = options.controller
    lines = []
    reasons = () if trace.verdict is None else trace.verdict.open_reasons
    if any(reason.code == "robot-assumed" or reason.object == "robot" for reason in reasons):
        lines.append(
            f"Next: name the robot, `tracerisk run {name} --robot NAME`, or in the settings by "
            "`tracerisk init --robot NAME`; `tracerisk robots` lists those that are known, "
            "`tracerisk docs howto-robot` says how to give your own."
        )
    if any(finding.kind == NOTHING_TO_GRASP for finding in trace.findings):
        lines.append(
            "Next: put objects where the finding says that a gripper closed on nothing; "
            "`tracerisk docs howto-scenario` shows how."
        )
    if trace.verdict is not None and trace.verdict.is_bad:
        again = f"`tracerisk run {name}` again"
        if is_brief:
            again = f"`tracerisk run {name} -v`, which prints all findings"
        lines.append(f"Next: mend what {'else ' if lines else ''}the verdict names, then {again}.")
    if lines:
        return lines
    if reasons and all(reason.code in GAPS for reason in reasons):
        lines.append(
            f"Note: what never ran has no part in the figure; `tracerisk check {name}` passes "
            "that, unless `min_coverage` is set or a change made it so; with `-v` it prints the "
            "entry that accepts it."
        )
    if options.check or options.diff:
        return [*lines, f"Next: `tracerisk run {name}` writes the blocks; nothing is written yet."]
    verbose = "`-v` prints components and assumptions, " if is_brief else ""
    return [
        *lines,
        f"Next: of `tracerisk run {name}`, {verbose}`--explain FUNCTION` a figure by hand, "
        "`--report OUT.html` the replay; commit the blocks with tracerisk.lock.",
    ]


def _caution(trace: Trace) -> str:
    """Return what the figure of a run that went wrong is of; empty for all others."""
    if trace.verdict is None or not trace.verdict.is_bad:
        return ""
    what = "went wrong" if trace.end.is_good else "was cut short"
    return f"That is of what ran: the run {what}, and its figure passes no limit."


def _notes(options: argparse.Namespace, done: Assessed, trace: Trace) -> list[str]:
    """Return how the run went and what became of the blocks, a line each."""
    blocks = blocks_line(
        str(done.controller.path),
        len(done.annotated.computed.blocks),
        keeps_files=keeps_files(options),
        is_changed=done.annotated.is_changed,
    )
    lock = done.annotated.lock_path
    if not keeps_files(options) and lock.parent.resolve() != Path.cwd().resolve():
        blocks += f", of {os.path.relpath(lock)}"
    reasons = () if trace.verdict is None else trace.verdict.open_reasons
    if done.annotated.is_changed and not keeps_files(options) and (reasons or trace.findings):
        blocks += "; lines named here are those of the file with them"
        if trace.verdict is not None and trace.verdict.is_bad:
            why = f"the run is {trace.verdict.kind}"
            blocks += f"; `tracerisk check {options.controller}` refuses them, for {why}"
    return [headline(trace), *object_lines(trace), blocks]
