"""`tracerisk success`: what a good run brought about, as a mission to confirm."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk import api
from tracerisk.cli.authors.scenario import scenario_file, write_scenario
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, show
from tracerisk.cli.shared.progress import progress_bar
from tracerisk.cli.shared.run_report import print_failure, trace_as_typed
from tracerisk.cli.shared.verdict import print_verdict, verdict_exit, verdict_json
from tracerisk.common.text.plain_data import picked
from tracerisk.errors import InputError, Location

if TYPE_CHECKING:
    from tracerisk.pipeline.scenarios.success_draft import SuccessDraft


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "--write",
        action="store_true",
        help="put what is missing under success of the scenario, each line to confirm",
    )
    parser.add_argument(
        "-o", "--output", metavar="OUT.yaml", help="where --write writes; what is there is kept"
    )
    shared.add_run_options(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code: that of the run, which drafts nothing if faulted."""
    from tracerisk.pipeline.scenarios.success_draft import draft_success

    if options.output is not None and not options.write:
        raise InputError("--output says where --write writes; give both, or neither")
    controller = api.load_controller(options.controller)
    settings = api.load_settings(controller, shared.run_settings(options))
    base = None if settings.scenario is None else Path(settings.scenario)
    output = Path(options.output) if options.output is not None else base
    output = output or scenario_file(controller)
    if base is None and options.write and output.exists():
        base = output
        settings = replace(settings, scenario=str(base))
    if options.write and base is not None and output.exists() and not output.samefile(base):
        raise InputError(
            f"is there already and would be lost; name it with --scenario, or another with -o "
            f"(the scenario is {base})",
            Location(str(output)),
        )
    shown = progress_bar(quiet=options.quiet, controller=options.controller)
    with shown as progress:
        draft = draft_success(controller, settings, base, progress=progress)
    is_good = verdict_exit(draft.trace.verdict) == 0 and draft.trace.is_usable
    is_written = options.write and is_good and bool(draft.conditions)
    if is_written:
        write_scenario(output, draft.text)
    code = int(verdict_exit(draft.trace.verdict))
    if options.json:
        print_json(
            "success",
            exit_code=code,
            **verdict_json(draft.trace.verdict),
            drafted=[picked(drafted, "value", "words") for drafted in draft.conditions],
            written=str(output) if is_written else None,
        )
        return code
    typed = trace_as_typed(draft.trace, controller.path)
    if not is_good:
        note("A faulted or stuck run is no example of the mission: nothing is drafted.")
        if draft.trace.is_usable:
            print_verdict(typed.verdict, options)
            return code
        return print_failure(typed)
    _print(options, draft, output)
    note(f"the run: {typed.verdict}", quiet=options.quiet)
    return code


def _print(options: argparse.Namespace, draft: SuccessDraft, output: Path) -> None:
    if not draft.conditions:
        show("The run brought about nothing that the scenario does not say already.")
        return
    show("success:", *(line for drafted in draft.conditions for line in drafted.lines))
    if options.write:
        note(
            f"written: {output}; every run with --scenario is judged by it. Delete the mark "
            "`# assumed` of what the mission is, and the line of what is by chance",
            quiet=options.quiet,
        )
    else:
        note("--write puts this into the scenario", quiet=options.quiet)
