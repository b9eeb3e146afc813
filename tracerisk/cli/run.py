"""`tracerisk run`: trace, annotate in place, build, solve, and print the table."""

from __future__ import annotations

import argparse
import contextlib
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.cli import options as shared
from tracerisk.cli.assessment import print_assessment, risk_exit
from tracerisk.cli.explain import derivation_json, explained, print_derivation
from tracerisk.cli.hardware_spread import (
    add_run_uncertainty,
    check_run_uncertainty,
    uncertainty_of_run,
)
from tracerisk.cli.output import (
    note,
    note_warnings,
    print_diffs,
    print_json,
    progress_bar,
    write_sarif,
)
from tracerisk.cli.report_input import RunShown, report_html
from tracerisk.cli.run_report import (
    blocks_line,
    failure_of,
    finding_exit,
    finding_lines,
    headline,
    object_lines,
    print_failure,
    write_file,
    write_outputs,
)
from tracerisk.cli.what_if import print_what_if, what_if_data
from tracerisk.errors import ControllerFailedError, ExitCode, Location

if TYPE_CHECKING:
    from tracerisk.pipeline import Controller
    from tracerisk.trace import Trace

_NO_FAILURE = frozenset({"assumed_name", "unused"})


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
    parser.add_argument(
        "--max-risk",
        metavar="P",
        type=shared.probability,
        help="exit 1 if the mission's failure probability is above P",
    )
    shared.add_fail_on(parser)
    shared.add_sarif(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    from tracerisk import pipeline, trace_json
    from tracerisk.pipeline.run_section import recorded_run, run_section
    from tracerisk.pipeline.stages import blocks_of
    from tracerisk.prm.formats import model_json
    from tracerisk.prm.formats.assessment_json import assessment_to_json
    from tracerisk.report.run_figures import run_figures, set_by_hand

    check_run_uncertainty(options)
    profile = shared.read_profile(options)
    policy = shared.merge_policy(options)
    controller = pipeline.load_controller(options.controller)
    given = shared.run_settings(options)
    settings = pipeline.load_settings(controller, given)
    pipeline.check_blocks(controller)
    with _recording_folder(options) as keep:
        with progress_bar(settings.duration_s, quiet=options.quiet) as progress:
            trace = pipeline.trace_controller(controller, settings, keep=keep, progress=progress)
        recorded = None
        if keep is not None and options.report is not None and trace.end.is_good:
            recorded = recorded_run(keep)
    if not trace.end.is_good:
        if options.trace is not None:
            write_file(options.trace, trace_json.dumps(trace))
        code = print_failure(trace)
        if options.json:
            print_json(
                "run", exit_code=code, error=failure_of(trace), trace=trace_json.trace_data(trace)
            )
        return code
    if not trace.functions:
        raise _nothing_commanded(trace, controller)
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
    assessment = pipeline.solve(model)
    blocks = [block for _, block in blocks_of(sources)]
    instances = annotated.computed.instances
    figures = run_figures(assessment, hardware, instances, blocks)
    uncertainty = uncertainty_of_run(
        model, hardware, instances, set_by_hand(blocks), options, seed=settings.seed
    )
    derivation = explained(options, annotated, hardware, settings)
    keeps_files = options.check or options.diff
    if not keeps_files:
        annotated.write()
        trace = pipeline.at_annotated_lines(trace, annotated)
    if options.trace is not None:
        write_file(options.trace, trace_json.dumps(trace))
    if options.sarif is not None:
        from tracerisk.pipeline.alerts import run_alerts

        write_sarif(options.sarif, run_alerts(trace, controller.root))
    if options.report is not None:
        section = run_section(trace, hardware, recorded)
        shown = RunShown(trace, hardware, annotated.computed, () if section is None else (section,))
        write_file(options.report, report_html(assessment, model, sources, run=shown))
    code = max(risk_exit(assessment, options.max_risk), finding_exit(trace, settings.fail_on))
    if options.check and annotated.is_changed:
        code = ExitCode.WOULD_CHANGE
    if options.json:
        print_json(
            "run",
            exit_code=int(code),
            trace=trace_json.trace_data(trace),
            objects=trace_json.trace_data(trace)["objects"],
            assessment=assessment_to_json(assessment),
            assumptions=[*trace.assumptions, *annotated.computed.assumptions],
            model=model_json.model_data(model),
            **derivation_json(derivation),
            **figures.data(annotated.computed.names),
            **what_if_data([], (), uncertainty),
        )
        return int(code)
    if options.diff:
        print_diffs(annotated)
    quiet = options.quiet
    note(headline(trace), quiet=quiet)
    for line in object_lines(trace):
        note(line, quiet=quiet)
    line = blocks_line(
        str(controller.path),
        len(annotated.computed.blocks),
        keeps_files=keeps_files,
        is_changed=annotated.is_changed,
    )
    note(line, quiet=quiet)
    if not options.diff:
        print_assessment(
            assessment,
            exposures=annotated.computed.exposures_by_name,
            findings=finding_lines(trace),
            assumptions=(*trace.assumptions, *annotated.computed.assumptions),
            tables=figures.tables(),
        )
        print_what_if(assessment, [], uncertainty, importance=False, pairs=None)
    print_derivation(derivation)
    return int(code)


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
