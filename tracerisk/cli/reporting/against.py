"""`--against REV`: the difference to an earlier revision, for the verbs that write a report."""

from __future__ import annotations

import argparse

from tracerisk.common.dependencies import require_runs
from tracerisk.errors import InputError


def add_against(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    parser.add_argument(
        "--against",
        metavar="REV",
        help="show the difference to this git revision in the report, with both runs side by side "
        "where their recordings are kept; A...HEAD is the merge base of both",
    )


def add_earlier_run(parser: argparse.ArgumentParser) -> None:
    """Add the options that bring the run of that revision."""
    parser.add_argument(
        "--against-recording",
        metavar="PATH",
        help="the recording of the run of --against: what `run --keep DIR` left, a .replay file, "
        "or the .tracerisk_cache of another machine (default: the cached one)",
    )
    parser.add_argument(
        "--run-against",
        action="store_true",
        help="run the controller as it was at --against once more, in a folder of its own, if its "
        "recording is not kept",
    )


def check_earlier_run(options: argparse.Namespace) -> None:
    """Raise InputError where options that bring an earlier run name no revision.

    And DependencyError or OtherSystemError where it is to run and no controller can run here.
    """
    for name in ("against_recording", "run_against"):
        if getattr(options, name) and options.against is None:
            raise InputError(f"--{name.replace('_', '-')} goes with --against; add it")
    if options.run_against:
        require_runs("running the earlier version (--run-against)")


def check_against(options: argparse.Namespace) -> None:
    """Read the option before a run; raise what would keep its report from showing the difference.

    Raises InputError where the option has nothing to go with, or git does not know the revision.
    """
    if options.against is None:
        return
    if options.report is None:
        raise InputError("--against goes with --report; add it, or ask `tracerisk diff`")
    if options.check or options.diff:
        given = "--check" if options.check else "--diff"
        raise InputError(
            f"--against compares with the sources as the run writes them, and {given} writes none"
        )
    from tracerisk.cli.reporting.comparison import check_revision

    check_revision(options.against)
