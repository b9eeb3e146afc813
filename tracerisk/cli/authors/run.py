"""`tracerisk run`: trace, annotate in place, build, solve, and print the table."""

from __future__ import annotations

import argparse

from tracerisk.cli.reporting.against import add_against, check_against
from tracerisk.cli.running.fault import add_fault, check_fault_options, run_faults
from tracerisk.cli.running.finished_run import finish_run
from tracerisk.cli.running.live_command import name_source
from tracerisk.cli.running.shown import show_failure, show_run
from tracerisk.cli.running.watch import watch_run
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.progress import progress_bar
from tracerisk.cli.solving.hardware_spread import add_run_uncertainty, check_run_uncertainty
from tracerisk.common.worlds.world import ALL, worlds_named
from tracerisk.errors import InputError
from tracerisk.trace import RunFailedError


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
    parser.add_argument(
        "--worlds",
        metavar="NAMES",
        nargs="?",
        const=ALL,
        default="",
        help="run it again in worlds that a cell may be, all or those named between commas, and "
        "exit 1 if verdict or outcome depend on one (`tracerisk docs worlds`)",
    )
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
    words = "exit 1 if the mission's failure probability is above P"
    shared.add_max_failure_probability(parser, words)
    shared.add_max_undetected_probability(parser)
    shared.add_fail_on(parser)
    shared.add_sarif(parser)
    words = "print every component, table and assumption (default where output is no terminal)"
    shared.add_json(parser, verbose=words)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    name_source(options)
    check_fault_options(options)
    check_run_uncertainty(options)
    check_against(options)
    _check_watch(options)
    _check_worlds(options)
    if options.watch:
        watch_run(options)

    try:
        if options.faults:
            return run_faults(options)
        with progress_bar(quiet=options.quiet, controller=options.controller) as progress:
            done = finish_run(options, progress)
    except RunFailedError as error:
        return show_failure(options, error.trace)
    return show_run(options, done)


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


def _check_worlds(options: argparse.Namespace) -> None:
    """Raise InputError for worlds that there are not, and for what does not go with them."""
    if not options.worlds:
        return
    worlds_named(options.worlds)
    for name in ("watch", "live", "faults"):
        if getattr(options, name):
            option = "--fault" if name == "faults" else f"--{name}"
            raise InputError(f"--worlds goes with a single run without a fault; leave out {option}")
