"""`tracerisk run`: trace, annotate in place, build, solve, and print the table."""

from __future__ import annotations

import argparse
import contextlib
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.cli.against import add_against, check_against, review_against
from tracerisk.cli.explain import derivation_json, explained, print_derivation
from tracerisk.cli.hardware_spread import (
    add_run_uncertainty,
    check_run_uncertainty,
    uncertainty_of_run,
)
from tracerisk.cli.shared import options as shared
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
from tracerisk.cli.shared.report_input import RunShown, report_html
from tracerisk.cli.shared.run_report import (
    blocks_line,
    failure_of,
    finding_exit,
    finding_lines,
    headline,
    note_draft,
    object_lines,
    print_failure,
    write_outputs,
)
from tracerisk.cli.verdict import print_verdict, verdict_details, verdict_exit, verdict_json
from tracerisk.cli.what_if import print_what_if, what_if_data
from tracerisk.errors import ControllerFailedError, ExitCode, Location
from tracerisk.trace import Trace, verdict_line

if TYPE_CHECKING:
    from tracerisk.adder.figures.derivation import FunctionDerivation
    from tracerisk.config import Settings
    from tracerisk.pipeline import Annotated, Controller
    from tracerisk.pipeline.run.controller_run import Progress
    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.prm.questions.uncertainty import Uncertainty
    from tracerisk.report.run_figures import RunFigures

_NO_FAILURE = frozenset({"assumed_name", "assumed_start", "unused"})


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    shared.add_run_options(parser)
    shared.add_hardware_options(parser)
    shared.add_write_options(parser)
    shared.add_edit_options(parser)
    shared.add_profile(parser)
    shared.add_explain(parser)
    add_run_uncertainty(parser)
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
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    check_run_uncertainty(options)
    check_against(options)
    with progress_bar(quiet=options.quiet) as progress:
        done = _assess(options, progress or _untold)
    return _failed(options, done) if isinstance(done, Trace) else _told(options, done)


@dataclass(frozen=True, slots=True)
class _Assessed:
    """What a run that ended well came to; everything that was asked for as a file is written."""

    controller: Controller
    settings: Settings
    trace: Trace
    annotated: Annotated
    model: HybridModel
    assessment: Assessment
    figures: RunFigures
    uncertainty: Uncertainty | None
    derivation: FunctionDerivation | None


def _assess(options: argparse.Namespace, progress: Progress) -> _Assessed | Trace:
    """Run the stages and write what they are to write; return the trace of a bad end."""
    from tracerisk import pipeline, trace_json
    from tracerisk.pipeline.results.run_section import recorded_run, run_section
    from tracerisk.pipeline.stages import blocks_of
    from tracerisk.prm.formats import model_json
    from tracerisk.report.run_figures import run_figures, set_by_hand

    profile = shared.read_profile(options)
    policy = shared.merge_policy(options)
    controller = pipeline.load_controller(options.controller)
    given = shared.run_settings(options)
    settings = pipeline.load_settings(controller, given)
    pipeline.check_blocks(controller)
    with _recording_folder(options) as keep:
        told = None if progress is _untold else progress
        trace = pipeline.trace_controller(controller, settings, keep=keep, progress=told)
        recorded = None
        if keep is not None and options.report is not None and trace.is_usable:
            recorded = recorded_run(keep)
    if not trace.is_usable:
        return trace
    if not trace.functions:
        raise _nothing_commanded(trace, controller)
    simulated_s = trace.end.simulated_s or 0.0
    progress("annotating", simulated_s)
    hardware = pipeline.load_hardware(settings, trace.robot)
    note_warnings(hardware, quiet=options.quiet)
    annotated = pipeline.annotate(
        controller, trace, hardware, settings, policy=policy, profile=profile, given=given
    )
    write_outputs(options, annotated.computed)
    sources = {str(controller.path_of(file)): text for file, text in annotated.sources.items()}
    model = pipeline.build(sources, name=controller.path.name)
    if options.model is not None:
        write_file(options.model, model_json.dumps(model))
    progress("solving", simulated_s)
    assessment = pipeline.solve(model)
    blocks = [block for _, block in blocks_of(sources)]
    instances = annotated.computed.instances
    figures = run_figures(assessment, hardware, instances, blocks)
    uncertainty = uncertainty_of_run(
        model, hardware, instances, set_by_hand(blocks), options, seed=settings.seed
    )
    derivation = explained(options, annotated, hardware, settings)
    if not (options.check or options.diff):
        annotated.write()
        trace = pipeline.at_annotated_lines(trace, annotated)
    if options.trace is not None:
        write_file(options.trace, trace_json.dumps(trace))
    if options.sarif is not None:
        from tracerisk.pipeline.results.alerts import run_alerts

        write_sarif(options.sarif, run_alerts(trace, controller.root))
    if options.report is not None:
        progress("report", simulated_s)
        section = run_section(trace, hardware, recorded)
        shown = RunShown(trace, hardware, annotated.computed, () if section is None else (section,))
        review = review_against(options.against, sources)
        verdict = (verdict_line(trace.verdict), *verdict_details(trace.verdict))
        page = report_html(assessment, model, sources, run=shown, review=review, verdict=verdict)
        write_file(options.report, page)
    return _Assessed(
        controller, settings, trace, annotated, model, assessment, figures, uncertainty, derivation
    )


def _untold(_phase: str, _simulated_s: float) -> None:
    """Stand for a progress that nobody sees."""


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


def _told(options: argparse.Namespace, done: _Assessed) -> int:
    """Print the results of a run, most important first; return the exit code."""
    from tracerisk import trace_json
    from tracerisk.prm.formats import model_json
    from tracerisk.prm.formats.assessment_json import assessment_to_json

    trace, annotated, assessment = done.trace, done.annotated, done.assessment
    note_draft(trace, quiet=options.quiet)
    code = max(
        verdict_exit(trace.verdict),
        risk_exit(assessment, options.max_failure_probability),
        finding_exit(trace, done.settings.fail_on),
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
            model=model_json.model_data(done.model),
            **derivation_json(done.derivation),
            **done.figures.data(annotated.computed.names),
            **what_if_data([], (), done.uncertainty),
        )
        return int(code)
    print_verdict(trace.verdict, options)
    if options.diff:
        print_diffs(annotated)
    for line in _notes(options, done):
        note(line, quiet=options.quiet)
    if not (options.diff or options.quiet):
        print_assessment(
            assessment,
            exposures=annotated.computed.exposures_by_name,
            findings=finding_lines(trace),
            assumptions=(*trace.assumptions, *annotated.computed.assumptions),
            tables=done.figures.tables(terminal_width()),
        )
    if not options.diff:
        print_what_if(assessment, [], done.uncertainty, importance=False, pairs=None)
    print_derivation(done.derivation)
    return int(code)


def _notes(options: argparse.Namespace, done: _Assessed) -> list[str]:
    """Return how the run went and what became of the blocks, a line each."""
    blocks = blocks_line(
        str(done.controller.path),
        len(done.annotated.computed.blocks),
        keeps_files=options.check or options.diff,
        is_changed=done.annotated.is_changed,
    )
    return [headline(done.trace), *object_lines(done.trace), blocks]


@contextlib.contextmanager
def _recording_folder(options: argparse.Namespace) -> Iterator[Path | None]:
    """Give the folder in which the recording stays for as long as it is needed."""
    if options.keep is not None:
        yield Path(options.keep)
    elif options.report is None:
        yield None
    else:
        with tempfile.TemporaryDirectory(prefix="tracerisk-") as folder:
            yield Path(folder)


def _nothing_commanded(trace: Trace, controller: Controller) -> ControllerFailedError:
    """Return the error of a run in which no hardware was commanded, with what it showed instead."""
    message = f"{trace.end.message}, and it commanded no hardware: there is no risk to assess"
    if not trace.findings:
        hint = "does it need arguments (after --) or answers (--answer)?"
        start = Location(str(controller.path), 1)
        return ControllerFailedError(f"{message}; {hint}", start, trace.end.scenario)
    # What went wrong says more than what was assumed before it.
    first = min(trace.findings, key=lambda each: each.kind in _NO_FAILURE)
    more = len(trace.findings) - 1
    also = f" (and {more} more, which `tracerisk trace` tells)" if more else ""
    found = first.location
    place = None if found is None else replace(found, file=str(controller.path_of(found.file)))
    return ControllerFailedError(f"{message}; {first.message}{also}", place, trace.end.scenario)
