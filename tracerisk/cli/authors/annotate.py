"""`tracerisk annotate`: write risk blocks into a controller from a trace or a log."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, get_args

from tracerisk import api
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.explain import derivation_json, explained, print_derivation
from tracerisk.cli.shared.output import note, note_warnings, print_diff, print_diffs, print_json
from tracerisk.cli.shared.run_report import blocks_line
from tracerisk.cli.shared.sources import decoded, read_file, read_profile
from tracerisk.common import trace_json
from tracerisk.common.trace_log import read_log
from tracerisk.config import BlockForm
from tracerisk.errors import ExitCode, InputError, Location
from tracerisk.pipeline.annotate import in_form
from tracerisk.pipeline.freshness.known_functions import check_blocks

if TYPE_CHECKING:
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.trace import Trace


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument("controller", metavar="FILE", help="a controller in Python, C or C++")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--trace", metavar="FILE", help="a trace, as `tracerisk trace -o` wrote it")
    source.add_argument("--log", metavar="FILE", help="a log in the published text format")
    source.add_argument(
        "--form",
        choices=get_args(BlockForm),
        help="convert the blocks that it has: compact, published",
    )
    shared.add_hardware_options(parser)
    shared.add_profile(parser)
    shared.add_write_options(parser)
    shared.add_edit_options(parser)
    shared.add_explain(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    controller = api.load_controller(options.controller)
    if options.form is not None:
        return _convert(options, controller)
    profile = read_profile(options)
    given = shared.run_settings(options)
    settings = api.load_settings(controller, given)
    check_blocks(controller)
    trace = _read_trace(options, controller)
    if not trace.robot and settings.hardware is None:
        raise InputError(
            "a log names no robot, so no hardware description can be chosen; "
            "give one with --hardware FILE"
        )
    hardware = api.load_hardware(settings, trace.robot)
    note_warnings(hardware, quiet=options.quiet)
    annotated = api.annotate(
        controller,
        trace,
        hardware,
        settings,
        policy=shared.merge_policy(options),
        profile=profile,
        given=given,
    )
    derivation = explained(options, annotated, hardware, settings)
    keeps_files = options.check or options.diff
    if not keeps_files:
        annotated.write()
    would_change = options.check and annotated.is_changed
    code = ExitCode.WOULD_CHANGE if would_change else ExitCode.FINE
    blocks = list(annotated.computed.names.values())
    if options.json:
        print_json(
            "annotate",
            exit_code=int(code),
            changed=annotated.is_changed,
            blocks=blocks,
            assumptions=list(annotated.computed.assumptions),
            **derivation_json(derivation),
        )
        return int(code)
    if options.diff:
        print_diffs(annotated)
    line = blocks_line(
        str(controller.path),
        len(annotated.computed.blocks),
        keeps_files=keeps_files,
        is_changed=annotated.is_changed,
    )
    note(line, quiet=options.quiet)
    for line in annotated.computed.assumptions:
        note(f"assumed: {line}", quiet=options.quiet)
    print_derivation(derivation)
    return int(code)


def _convert(options: argparse.Namespace, controller: Controller) -> int:
    """Write the blocks of a controller in the form that was asked for, and nothing else."""
    converted = in_form(controller, options.form)
    names = [str(controller.path_of(source.file)) for source in converted.sources]
    if options.diff:
        for source, name in zip(converted.sources, names, strict=True):
            print_diff(source.before, source.after, name)
    keeps_files = options.check or options.diff
    if not keeps_files:
        converted.write()
    code = ExitCode.WOULD_CHANGE if options.check and names else ExitCode.FINE
    if options.json:
        print_json("annotate", exit_code=int(code), changed=bool(names), files=names)
        return int(code)
    verb = "would be converted to" if keeps_files else "converted to"
    for name in names:
        note(f"{name}: {verb} the {options.form} form", quiet=options.quiet)
    if not names:
        text = f"{controller.path}: all blocks are in the {options.form} form"
        note(text, quiet=options.quiet)
    return int(code)


def _read_trace(options: argparse.Namespace, controller: Controller) -> Trace:
    name = options.trace if options.trace is not None else options.log
    text = decoded(read_file(name), name)
    if options.log is not None:
        return read_log(text, name, controller=controller.file)
    trace = trace_json.loads(text, name)
    if not trace.is_usable:
        raise InputError(
            f"is the trace of a run that failed ({trace.end.message}); `tracerisk trace "
            f"{options.controller} -o {name}{controller.live_words}` makes another",
            Location(name),
        )
    if trace.controller != controller.file:
        raise InputError(
            f"is a trace of '{trace.controller}', not of '{controller.file}'", Location(name)
        )
    if trace.is_measured and trace.verdict is None and controller.path.suffix == ".py":
        raise InputError(
            "is of a real robot, and says nothing of functions that did not run: blocks of Python "
            "come from a run; take its shares with `tracerisk field` and --profile",
            Location(name),
        )
    return trace
