"""`tracerisk trace`: run a controller and report which hardware each function used."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk import api
from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.cli.running.live_command import name_source
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, scenario_advice, show, write_file
from tracerisk.cli.shared.progress import progress_bar
from tracerisk.cli.shared.recordings import add_reading, read_recording
from tracerisk.cli.shared.run_report import (
    failure_of,
    finding_lines,
    headline,
    note_draft,
    object_lines,
    print_failure,
    recording_folder,
    trace_as_typed,
    trace_lines,
    write_outputs,
    write_record,
)
from tracerisk.cli.shared.verdict import print_verdict, verdict_exit, verdict_json
from tracerisk.common import trace_json
from tracerisk.errors import InputError
from tracerisk.trace import LOST, MEASURED

if TYPE_CHECKING:
    from tracerisk.trace import Trace


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    shared.add_run_options(parser, needs_file=False)
    shared.add_live(parser)
    parser.add_argument(
        "--from",
        dest="recording",
        metavar="REC",
        help="read the trace from a recording: MCAP, bag or db3; runs nothing",
    )
    add_reading(parser, with_robot=False)
    shared.add_record(parser)
    shared.add_hardware_options(parser)
    parser.add_argument("-o", "--output", metavar="FILE", help="write the trace as JSON")
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    name_source(options)
    if options.recording is not None:
        trace = _read(options)
    elif options.controller is None:
        raise InputError("FILE is missing: name a controller, or a recording with --from")
    else:
        trace = _run(options)
    if options.output is not None:
        write_file(options.output, trace_json.dumps(trace))
    typed = trace
    if options.controller is not None:
        typed = trace_as_typed(trace, options.controller)
    note_draft(typed, quiet=options.quiet)
    code = 0 if trace.is_usable else print_failure(typed)
    code = code or int(verdict_exit(trace.verdict))
    if options.json:
        data = trace_json.trace_data(trace)
        verdict = verdict_json(trace.verdict)
        print_json("trace", exit_code=code, **verdict, error=failure_of(trace), trace=data)
    elif trace.is_usable:
        print_verdict(typed.verdict, options)
        note(headline(typed), quiet=options.quiet)
        for line in [*trace_lines(typed), *object_lines(typed), *finding_lines(typed)]:
            show(line)
        if trace.end.scenario:
            note(scenario_advice(trace.end.scenario), quiet=options.quiet)
        for line in trace.assumptions:
            listed = line.startswith((MEASURED, LOST))
            note(line if listed else f"assumed: {line}", quiet=options.quiet)
    return code


def _run(options: argparse.Namespace) -> Trace:
    shown = progress_bar(quiet=options.quiet, controller=options.controller)
    with shown as progress, recording_folder(options) as keep:
        controller = api.load_controller(options.controller)
        settings = api.load_settings(controller, shared.run_settings(options))
        trace = api.trace_controller(
            controller,
            settings,
            keep=keep,
            progress=progress,
            live_speed=shared.live_speed(options),
        )
        write_record(options, keep, trace)
    if options.log is not None:
        hardware = api.load_hardware(settings, trace.robot)
        write_outputs(options, compute_blocks(trace, hardware, active=settings.active))
    return trace


def _read(options: argparse.Namespace) -> Trace:
    given = {"--record": options.record, "--log": options.log, "--keep": options.keep}
    given |= {"--live": options.live or None, "--answer": options.answers or None}
    given |= {"--launch": options.launch, "--params": options.params or None}
    given |= {"--driver": options.drivers or None}
    given |= {"--scene": options.scene, "--scenario": options.scenario, "--seed": options.seed}
    for name, value in given.items():
        if value is not None:
            raise InputError(
                f"{name} does not go with --from: a recording is read and nothing is run"
            )
    return read_recording(Path(options.recording), options, options.controller)
