"""`tracerisk trace`: run a controller and tell which hardware each function used."""

from __future__ import annotations

import argparse
from pathlib import Path

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import (
    note,
    print_json,
    progress_bar,
    scenario_advice,
    show,
    write_file,
)
from tracerisk.cli.shared.run_report import (
    failure_of,
    finding_lines,
    headline,
    note_draft,
    object_lines,
    print_failure,
    trace_lines,
    write_outputs,
)
from tracerisk.cli.verdict import print_verdict, verdict_exit, verdict_json


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    shared.add_run_options(parser)
    shared.add_hardware_options(parser)
    parser.add_argument("-o", "--output", metavar="FILE", help="write the trace as JSON")
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    from tracerisk import pipeline, trace_json
    from tracerisk.adder.figures.computed import compute_blocks

    with progress_bar(quiet=options.quiet) as progress:
        controller = pipeline.load_controller(options.controller)
        settings = pipeline.load_settings(controller, shared.run_settings(options))
        trace = pipeline.trace_controller(
            controller,
            settings,
            keep=None if options.keep is None else Path(options.keep),
            progress=progress,
        )
    if options.output is not None:
        write_file(options.output, trace_json.dumps(trace))
    note_draft(trace, quiet=options.quiet)
    code = 0 if trace.is_usable else print_failure(trace)
    code = code or int(verdict_exit(trace.verdict))
    if options.log is not None:
        hardware = pipeline.load_hardware(settings, trace.robot)
        write_outputs(options, compute_blocks(trace, hardware, active=settings.active))
    if options.json:
        data = trace_json.trace_data(trace)
        verdict = verdict_json(trace.verdict)
        print_json("trace", exit_code=code, **verdict, error=failure_of(trace), trace=data)
    elif trace.is_usable:
        print_verdict(trace.verdict, options)
        note(headline(trace), quiet=options.quiet)
        for line in [*trace_lines(trace), *object_lines(trace), *finding_lines(trace)]:
            show(line)
        if trace.end.scenario:
            note(scenario_advice(trace.end.scenario), quiet=options.quiet)
        for line in trace.assumptions:
            note(f"assumed: {line}", quiet=options.quiet)
    return code
