"""`tracerisk mutate`: change the controller at one place at a time; list what nobody notices."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING

from tracerisk import api
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.campaign import add_campaign_options, campaign_options
from tracerisk.cli.shared.output import note, paper, print_json, print_text, show
from tracerisk.cli.shared.progress import bar_of_cells
from tracerisk.cli.shared.values import count, probability
from tracerisk.errors import ExitCode
from tracerisk.report import mutants as report

if TYPE_CHECKING:
    from tracerisk.report.mutants import MutantRuns


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    shared.add_run_options(parser)
    group = parser.add_argument_group("the changes")
    group.add_argument(
        "--most",
        metavar="N",
        type=count,
        help="changes to try, drawn by the seed from all places (default: 60)",
    )
    group.add_argument(
        "--min-noticed",
        metavar="F",
        type=probability,
        help="exit 1 if `success` notices less than this fraction of the changes that alter what "
        "the run brings about",
    )
    add_campaign_options(group, "change")
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb; 1 if too few changes are noticed, else 0."""
    with bar_of_cells("changes", "the run without a change", quiet=options.quiet) as progress:
        mutate = api.mutate(
            options.controller,
            shared.run_settings(options),
            campaign_options(options, progress),
            most=options.most,
        )
    least = options.min_noticed
    is_below = least is not None and mutate.share < least
    code = ExitCode.WOULD_CHANGE if is_below else ExitCode.FINE
    if options.json:
        print_json(
            "mutate",
            exit_code=int(code),
            altered=len(mutate.altered),
            noticed=mutate.share,
            places=mutate.places,
            planned=mutate.planned,
            runs=[
                {**asdict(run), "altered": run.is_altered, "noticed_by": run.noticed_by}
                for run in mutate.runs
            ],
            success=list(mutate.success),
            tried=len(mutate.runs),
            unchanged=mutate.unchanged,
        )
    else:
        print_text(report.render_mutants(mutate, paper()))
        show(report.summary_line(mutate))
    _note(options, mutate)
    if is_below:
        note(
            f"tracerisk: success notices {mutate.share:.3g} of them, below --min-noticed {least:g}"
        )
    return int(code)


def _note(options: argparse.Namespace, found: MutantRuns) -> None:
    if found.unchanged:
        note(
            f"the run without a change is {found.unchanged}; only what a change adds is noticed",
            quiet=options.quiet,
        )
    if len(found.runs) < found.planned:
        note(
            f"{len(found.runs)} of {found.planned} changes are tried; run the same command again",
            quiet=options.quiet,
        )
    if found.places > found.planned:
        note(
            f"{found.planned} of {found.places} possible changes were drawn; --most N tries more",
            quiet=options.quiet,
        )
    if not found.success:
        note(
            "no scenario declares `success`, so it notices nothing (`tracerisk docs mutation`)",
            quiet=options.quiet,
        )
