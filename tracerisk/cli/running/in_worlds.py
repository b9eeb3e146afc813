"""Print what of a run depends on the world around it, and make of it an exit code."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from tracerisk.cli.shared.output import note, paper, print_text
from tracerisk.common.text.plain_data import plain_data
from tracerisk.common.worlds.world_run import WorldRun, dependence_line, depending
from tracerisk.errors import ExitCode
from tracerisk.report.worlds import render_worlds, worlds_line


def worlds_exit(runs: Sequence[WorldRun]) -> ExitCode:
    """Return 1 where verdict or outcome depend on a world, else 0."""
    return ExitCode.WOULD_CHANGE if depending(runs) else ExitCode.FINE


def print_worlds(runs: Sequence[WorldRun], options: argparse.Namespace) -> None:
    """Print what depends on which world; of a quiet command only what makes it fail."""
    if not runs:
        return
    if options.quiet or options.diff:
        # Where a diff of the sources is on standard output, nothing else is.
        for run in depending(runs):
            note(f"tracerisk: {dependence_line(run)}")
        return
    print_text(f"{render_worlds(runs, paper())}\n{worlds_line(runs)}\n")


def worlds_json(runs: Sequence[WorldRun]) -> list[dict[str, Any]]:
    """Return the runs in worlds for a `--json`: what each changed, and whether anything depends."""
    return [{**plain_data(run), "changed": run.changed, "depends": run.depends} for run in runs]
