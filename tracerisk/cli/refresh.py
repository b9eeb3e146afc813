"""`tracerisk refresh`: bring blocks up to date, simulating only what is stale."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.cli import options as shared
from tracerisk.cli.output import note, print_diffs, print_json, progress_bar
from tracerisk.cli.verdict import verdict_exit, verdict_json
from tracerisk.errors import ExitCode, InputError, TraceRiskError
from tracerisk.trace import verdict_line

if TYPE_CHECKING:
    from tracerisk.pipeline.refresh import Refreshed


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        help="a controller, or what one depends on; else all of the lock in this folder",
    )
    shared.add_write_options(parser)
    shared.add_edit_options(parser)
    shared.add_sandbox(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    from tracerisk.pipeline.check import controllers_in, controllers_of
    from tracerisk.pipeline.refresh import refresh_controller

    paths = controllers_of(options.files) if options.files else controllers_in(Path())
    if not options.files and not paths:
        raise InputError("no tracerisk.lock in this folder knows a controller; name a FILE")
    policy = shared.merge_policy(options)
    outcomes: list[dict[str, Any]] = []
    code = ExitCode.FINE
    for path in paths:
        try:
            with progress_bar(quiet=options.quiet) as progress:
                done = refresh_controller(
                    path, policy=policy, sandbox=options.sandbox, progress=progress
                )
            would_change = _settle(done, options)
        except TraceRiskError as error:
            # The others are refreshed all the same; what failed is told and decides the code.
            code = max(code, error.exit_code)
            outcomes.append({"controller": str(path), "error": str(error), "code": error.code})
            note(f"tracerisk: {error.with_code}")
            continue
        if would_change:
            code = max(code, ExitCode.WOULD_CHANGE)
        code = max(code, verdict_exit(done.verdict))
        outcomes.append(
            {
                "controller": str(path),
                "how": done.how,
                "changed": done.is_changed,
                **verdict_json(done.verdict),
            }
        )
        state = "changed" if done.is_changed else "unchanged"
        note(f"{path}: {verdict_line(done.verdict)}", quiet=options.quiet)
        note(f"{path}: {state} ({done.reason})", quiet=options.quiet)
    if options.json:
        print_json("refresh", exit_code=int(code), controllers=outcomes)
    return int(code)


def _settle(done: Refreshed, options: argparse.Namespace) -> bool:
    """Write or show what changed; say whether `--check` is to tell of it."""
    if done.annotated is None or not done.is_changed:
        return False
    if options.diff:
        print_diffs(done.annotated)
    if options.check or options.diff:
        return bool(options.check)
    done.annotated.write()
    return False
