"""`tracerisk run`: trace, annotate in place, build, solve, and print the table."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from tracerisk.cli.explain import derivation_json, explained, print_derivation
from tracerisk.cli.fault import add_fault, check_fault_options, run_faults
from tracerisk.cli.hardware_spread import (
    add_run_uncertainty,
    check_run_uncertainty,
    uncertainty_of_run,
)
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.against import add_against, check_against, review_against
from tracerisk.cli.shared.assessment import print_assessment, risk_exit
from tracerisk.cli.shared.output import (
    note,
    note_warnings,
    print_diffs,
    print_json,
    progress_bar,
    terminal_width,
    write_file,
    write_sarif,
)
from tracerisk.cli.shared.report_input import RunShown, evidence_shown, report_html
from tracerisk.cli.shared.run_report import (
    blocks_line,
    failure_of,
    finding_exit,
    finding_lines,
    headline,
    note_draft,
    object_lines,
    print_failure,
    recording_folder,
    write_outputs,
    write_record,
)
from tracerisk.cli.verdict import print_verdict, verdict_details, verdict_exit, verdict_json
from tracerisk.cli.what_if import print_what_if, what_if_data
from tracerisk.errors import DependencyError, ExitCode, InputError, TraceRiskError
from tracerisk.trace import Trace, verdict_line

if TYPE_CHECKING:
    from tracerisk.adder.figures.derivation import FunctionDerivation
    from tracerisk.api import Assessed
    from tracerisk.cli.shared.watching import Watch
    from tracerisk.pipeline.run.controller_run import Progress
    from tracerisk.prm.questions.uncertainty import Uncertainty
    from tracerisk.report.html.run.replay import RecordedRun
    from tracerisk.report.html.section import Section
    from tracerisk.report.run_figures import RunFigures


RUNNING = ("starting the twin", "simulating")
"""The phases of the progress in which the controller's own process is at work."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    shared.add_run_options(parser)
    shared.add_live(parser)
    shared.add_hardware_options(parser)
    shared.add_write_options(parser)
    parser.add_argument(
        "--watch",
        action="store_true",
        help="run it again whenever a file changes that it depends on; writes no source",
    )
    parser.add_argument("--write", action="store_true", help="with --watch: write sources and lock")
    shared.add_edit_options(parser)
    shared.add_profile(parser)
    shared.add_explain(parser)
    add_run_uncertainty(parser)
    add_fault(parser)
    shared.add_record(parser)
    parser.add_argument("--trace", metavar="FILE", help="write the trace as JSON")
    parser.add_argument("--model", metavar="FILE", help="write the risk model as JSON")
    parser.add_argument("--report", metavar="OUT.html", help="write a report as one HTML page")
    add_against(parser)
    parser.add_argument(
        "--max-failure-probability",
        "--max-risk",  # its older name
        metavar="P",
        type=shared.probability,
        help="exit 1 if the mission's failure probability is above P",
    )
    shared.add_fail_on(parser)
    shared.add_sarif(parser)
    parser.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        help="print every component, table and assumption (default where output is no terminal)",
    )
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    check_fault_options(options)
    check_run_uncertainty(options)
    check_against(options)
    _check_watch(options)
    from tracerisk.api import RunFailedError

    if options.watch:
        return _watch(options)
    try:
        if options.faults:
            return run_faults(options)
        with progress_bar(quiet=options.quiet, controller=options.controller) as progress:
            done = _done(options, progress)
    except RunFailedError as error:
        return _failed(options, error.trace)
    return _show(options, done)


@dataclass(frozen=True, slots=True)
class _Done:
    """What a run that ended well came to; everything that was asked for as a file is written."""

    assessed: Assessed
    figures: RunFigures
    uncertainty: Uncertainty | None
    derivation: FunctionDerivation | None


def _check_watch(options: argparse.Namespace) -> None:
    """Raise InputError for options that do not go together with `--watch`."""
    if options.write and not options.watch:
        raise InputError("--write goes with --watch; a run without it writes sources anyhow")
    if options.live and (options.watch or options.check or options.faults):
        name = "--watch" if options.watch else "--check" if options.check else "--fault"
        raise InputError(f"{name} goes with runs that can be repeated; leave out --live")
    if options.watch and (options.check or options.faults):
        name = "--check" if options.check else "--fault"
        raise InputError(f"{name} goes with a single run; leave out --watch")


def _watch(options: argparse.Namespace) -> NoReturn:
    """Run the controller again and again; ends by an interrupt."""
    from tracerisk import api
    from tracerisk.cli.shared.watching import watch
    from tracerisk.pipeline.freshness.watched_files import watched_files
    from tracerisk.sandbox.fork_server import several_come

    several_come()
    path = Path(options.controller)
    shared.read_profile(options)
    last: list[_Done] = []
    files = watched_files(path, None, None, None)

    def update(watched: Watch) -> Iterable[Path]:
        clock = _Clock()
        known = last[-1] if last else None
        try:
            with progress_bar(quiet=options.quiet, controller=options.controller) as bar:
                done = _done(options, _looking(watched, clock, bar), known)
        except api.RunFailedError as error:
            _failed(options, error.trace)
            return _of_failure(path, watched, error)
        except DependencyError:
            raise
        except TraceRiskError as error:
            note(f"tracerisk: {error.with_code}")
            return _of_failure(path, watched, error)
        if done is known:
            note(f"{path}: nothing that its figure depends on has changed", quiet=options.quiet)
        else:
            note(_followed(done, known, clock), quiet=options.quiet)
            _show(options, done)
        last[:] = [done]
        found = done.assessed
        return {*files, *watched_files(path, found.controller, found.trace, found.settings)}

    watch(files, update, quiet=options.quiet)


def _of_failure(path: Path, watched: Watch, error: TraceRiskError) -> Iterable[Path]:
    """Return the files that may hold what made a run fail."""
    place = [] if error.location is None else [Path(error.location.file)]
    return {*watched.files, *place, *path.parent.glob("*.py")}


@dataclass(slots=True)
class _Clock:
    """When an update began, and how long its controller ran [s of wall time]."""

    began: float = field(default_factory=time.monotonic)
    started: float | None = None
    ran_s: float = 0.0

    def pass_on(self, phase: str) -> None:
        """Take a phase that begins."""
        now = time.monotonic()
        if phase in RUNNING:
            self.started = self.started or now
        elif self.started is not None:
            self.ran_s += now - self.started
            self.started = None


def _looking(watched: Watch, clock: _Clock, bar: Progress | None) -> Progress:
    """Return what passes on the progress, and ends work on what has changed meanwhile."""

    def told(phase: str, simulated_s: float) -> None:
        watched.look()
        clock.pass_on(phase)
        if bar is not None:
            bar(phase, simulated_s)

    return told


def _followed(done: _Done, known: _Done | None, clock: _Clock) -> str:
    """Return how the figure moved, and how long that took, on one line."""
    wall_s = time.monotonic() - clock.began
    now = done.assessed.assessment.mission.failure_probability
    told = f"mission failure {now:.4g}"
    if known is not None:
        before = known.assessed.assessment.mission.failure_probability
        change = f" ({100.0 * (now / before - 1.0):+.3g} %)" if before > 0.0 else ""
        told += ", as before" if now == before else f", was {before:.4g}{change}"
    is_same = known is not None and done.assessed.trace is known.assessed.trace
    how = f"{wall_s:.2f} s, without a run"
    if not is_same:
        how = f"{wall_s:.2f} s, of which the run {clock.ran_s:.2f} s"
    return f"{told}; {how}"


def _done(
    options: argparse.Namespace, progress: Progress | None, known: _Done | None = None
) -> _Done:
    """Assess the controller, and write what is to be written.

    `known` is what an earlier call gave, which is returned where nothing at all has changed.
    Raises RunFailedError with the trace of a bad end.
    """
    from tracerisk import api
    from tracerisk.pipeline.results.run_section import recorded_run
    from tracerisk.pipeline.stages import blocks_of
    from tracerisk.report.run_figures import run_figures, set_by_hand

    recorded = None
    with recording_folder(options) as keep:
        try:
            done = api.assess(
                options.controller,
                shared.run_settings(options),
                policy=shared.merge_policy(options),
                profile=shared.read_profile(options),
                keep=keep,
                progress=progress,
                # A recording is that of a run.
                known=None if known is None or keep is not None else known.assessed,
                live_speed=shared.live_speed(options),
            )
        except api.RunFailedError as error:
            write_record(options, keep, error.trace)
            raise
        if keep is not None and options.report is not None:
            recorded = recorded_run(keep)
        if known is not None and _is_same(done, known.assessed):
            return known
        note_warnings(done.hardware, quiet=options.quiet)
        instances = done.annotated.computed.instances
        blocks = [block for _, block in blocks_of(done.sources)]
        found = _Done(
            done,
            run_figures(done.assessment, done.hardware, instances, blocks),
            uncertainty_of_run(
                done.model,
                done.hardware,
                instances,
                set_by_hand(blocks),
                options,
                seed=done.settings.seed,
            ),
            explained(options, done.annotated, done.hardware, done.settings),
        )
        if not _keeps_files(options):
            found = replace(found, assessed=api.write_blocks(done))
        # With the lines of the source as it is now, blocks and all: as --trace has them.
        write_record(options, keep, found.assessed.trace)
    if options.report is not None and progress is not None:
        progress("report", done.trace.end.simulated_s or 0.0)
    _write_files(options, found.assessed, recorded)
    return found


def _is_same(done: Assessed, known: Assessed) -> bool:
    """Return whether an assessment says nothing that an earlier one did not."""
    return (
        done.trace is known.trace
        and done.sources == known.sources
        and done.hardware == known.hardware
        and done.settings == known.settings
    )


def _keeps_files(options: argparse.Namespace) -> bool:
    """Return whether sources and lock are left as they are."""
    is_only_shown = options.check or options.diff or options.live
    return bool(is_only_shown or (options.watch and not options.write))


def _write_files(options: argparse.Namespace, done: Assessed, recorded: RecordedRun | None) -> None:
    """Write the files that were asked for beside the blocks."""
    from tracerisk import trace_json
    from tracerisk.prm.formats import model_json

    write_outputs(options, done.annotated.computed)
    if options.model is not None:
        write_file(options.model, model_json.dumps(done.model))
    if options.trace is not None:
        write_file(options.trace, trace_json.dumps(done.trace))
    if options.sarif is not None:
        from tracerisk.pipeline.results.alerts import run_alerts

        write_sarif(options.sarif, run_alerts(done.trace, done.controller.root))
    if options.report is not None:
        from tracerisk.pipeline.results.run_section import run_section

        section = run_section(done.trace, done.hardware, recorded)
        sections: tuple[Section, ...] = () if section is None else (section,)
        sections += evidence_shown(done.controller, done.settings, done.annotated.fingerprint)
        page = report_html(
            done.assessment,
            done.model,
            done.sources,
            run=RunShown(done.trace, done.hardware, done.annotated.computed, sections),
            review=review_against(options.against, done.sources),
            verdict=(verdict_line(done.trace.verdict), *verdict_details(done.trace.verdict)),
        )
        write_file(options.report, page)


def _failed(options: argparse.Namespace, trace: Trace) -> int:
    """Print how a run ended that ended badly; return the exit code."""
    from tracerisk import trace_json

    if options.trace is not None:
        write_file(options.trace, trace_json.dumps(trace))
    code = print_failure(trace)
    if options.report is not None:
        told = f"{options.report}: no report is written of a run that ended badly"
        kept = "; the file is an earlier one" if Path(options.report).exists() else ""
        note(f"{told}{kept}", quiet=options.quiet)
    if options.json:
        data = trace_json.trace_data(trace)
        verdict = verdict_json(trace.verdict)
        print_json("run", exit_code=code, **verdict, error=failure_of(trace), trace=data)
    return code


def _show(options: argparse.Namespace, done: _Done) -> int:
    """Print the results of a run, most important first; return the exit code."""
    from tracerisk import trace_json
    from tracerisk.prm.formats import model_json
    from tracerisk.prm.formats.assessment_json import assessment_to_json

    assessed = done.assessed
    trace, annotated, assessment = assessed.trace, assessed.annotated, assessed.assessment
    note_draft(trace, quiet=options.quiet)
    code = max(
        verdict_exit(trace.verdict),
        risk_exit(assessment, options.max_failure_probability),
        finding_exit(trace, assessed.settings.fail_on),
    )
    if options.check and annotated.is_changed:
        code = ExitCode.WOULD_CHANGE
    if options.json:
        print_json(
            "run",
            exit_code=int(code),
            **verdict_json(trace.verdict),
            **({} if trace.end.is_good else {"error": failure_of(trace)}),
            trace=trace_json.trace_data(trace),
            objects=trace_json.trace_data(trace)["objects"],
            assessment=assessment_to_json(assessment),
            assumptions=[*trace.assumptions, *annotated.computed.assumptions],
            model=model_json.model_data(assessed.model),
            **derivation_json(done.derivation),
            **done.figures.data(annotated.computed.names),
            **what_if_data([], (), done.uncertainty),
        )
        return int(code)
    print_verdict(trace.verdict, options)
    if options.diff:
        print_diffs(annotated)
    for line in _notes(options, assessed):
        note(line, quiet=options.quiet)
    if not (options.diff or options.quiet):
        print_assessment(
            assessment,
            exposures=annotated.computed.exposures_by_name,
            findings=finding_lines(trace),
            assumptions=(*trace.assumptions, *annotated.computed.assumptions),
            tables=done.figures.tables(terminal_width()),
            following=_following(options) if sys.stdout.isatty() and not options.verbose else None,
        )
    if not options.diff:
        print_what_if(assessment, [], done.uncertainty, importance=False, pairs=None)
    print_derivation(done.derivation, assessed.model, assessment)
    return int(code)


def _following(options: argparse.Namespace) -> list[str]:
    """Return what to do next, a line each."""
    name = options.controller
    return [
        f"Next: `tracerisk run {name} -v` prints components and assumptions, `--explain FUNCTION` "
        "a figure by hand, `--report OUT.html` the replay; commit the blocks with tracerisk.lock."
    ]


def _notes(options: argparse.Namespace, done: Assessed) -> list[str]:
    """Return how the run went and what became of the blocks, a line each."""
    blocks = blocks_line(
        str(done.controller.path),
        len(done.annotated.computed.blocks),
        keeps_files=_keeps_files(options),
        is_changed=done.annotated.is_changed,
    )
    return [headline(done.trace), *object_lines(done.trace), blocks]
