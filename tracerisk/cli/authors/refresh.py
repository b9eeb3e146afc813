"""`tracerisk refresh`: bring blocks up to date, simulating only what is stale."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.adder.lock.lock import LOCK_NAME, lock_key
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import (
    note,
    note_unread_hardware,
    note_without_controllers,
    print_diffs,
    print_json,
)
from tracerisk.cli.shared.progress import progress_bar
from tracerisk.cli.shared.run_report import note_draft, note_moved, trace_as_typed
from tracerisk.cli.shared.verdict import as_typed, verdict_exit, verdict_json, verdict_lines
from tracerisk.common.verdict import verdict_line
from tracerisk.config import controller_root
from tracerisk.errors import DependencyError, ExitCode, TraceRiskError
from tracerisk.pipeline.annotate import at_annotated_lines
from tracerisk.pipeline.check.refresh import refresh_controller
from tracerisk.pipeline.freshness.known_controllers import (
    forget_gone,
    moved_controllers,
    named_or_all,
    write_or_remove,
)
from tracerisk.pipeline.workspace.project import Project, Projects

if TYPE_CHECKING:
    from tracerisk.common.verdict import Verdict
    from tracerisk.pipeline.check.refresh import Refreshed


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        help="controller, or a file that one uses (default: all of the locks here and below)",
    )
    shared.add_write_options(parser)
    shared.add_edit_options(parser)
    shared.add_sandbox(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    projects = Projects()
    paths = named_or_all(options.files, projects)
    if not options.files:
        paths = tuple(dict.fromkeys((*paths, *moved_controllers(Path(), projects))))
    note_without_controllers(options, projects)
    policy = shared.merge_policy(options)
    outcomes: list[dict[str, Any]] = []
    code = ExitCode.FINE
    # A controller that has another name now takes its entry along when it is written.
    roots = dict.fromkeys(map(controller_root, paths))
    gone = {root: forget_gone(root, write=False) for root in roots}
    for path in paths:
        if not path.is_file():
            continue
        try:
            with progress_bar(quiet=options.quiet) as progress:
                done = refresh_controller(
                    path, projects, policy=policy, sandbox=options.sandbox, progress=progress
                )
            would_change = _settle(done, path, options)
        except DependencyError:
            raise  # reported once: no other controller would fare better
        except TraceRiskError as error:
            # The others are refreshed all the same; what failed is reported and decides the code.
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
        if done.annotated is not None:
            note_draft(trace_as_typed(done.annotated.trace, path), quiet=options.quiet)
        note_moved(done.moved, path, quiet=options.quiet)
        verdict = as_typed(_verdict(done, options), path)
        is_fine = verdict_exit(verdict) == ExitCode.FINE
        first, *details = [verdict_line(verdict)] if is_fine else verdict_lines(verdict)
        for line in (f"{path}: {first}", *(f"  {detail}" for detail in details)):
            note(line, quiet=options.quiet)
        note(f"{path}: {_state(done, path)}", quiet=options.quiet)
    note_unread_hardware(paths, projects, quiet=options.quiet)
    forgotten = _forget(gone, paths, options)
    if forgotten and options.check:
        code = max(code, ExitCode.WOULD_CHANGE)
    if options.json:
        print_json("refresh", exit_code=int(code), controllers=outcomes, forgotten=forgotten)
    return int(code)


def _verdict(done: Refreshed, options: argparse.Namespace) -> Verdict | None:
    """Return the verdict with the lines that the sources have now."""
    if done.annotated is None or options.check or options.diff:
        return done.verdict
    return at_annotated_lines(done.annotated.trace, done.annotated).verdict


def _state(done: Refreshed, path: Path) -> str:
    """Return what became of the blocks of a controller, and why."""
    if done.how != "kept":
        return f"{'changed' if done.is_changed else 'unchanged'} ({done.reason})"
    return (
        f"unchanged ({done.reason}): the blocks of its last good run stay, and are stale; mend the "
        f"controller and refresh it again, or `tracerisk run {path}` writes those of this run"
    )


def _forget(
    gone: Mapping[Path, Sequence[str]], paths: Sequence[Path], options: argparse.Namespace
) -> list[str]:
    """Take controllers that are gone out of the locks of the others; return their paths.

    One that a lock knows stays where another could not be refreshed for the first time: that may
    be the same under its new name.
    """
    forgotten = []
    is_written = not (options.check or options.diff)
    for root, names in gone.items():
        known = Project(root).lock.controllers
        here = [path for path in paths if path.is_file() and controller_root(path) == root]
        new = [str(path) for path in here if lock_key(path, root) not in known]
        if names and is_written and not new:
            forget_gone(root)
        for name in names:
            if is_written and new and name in known:
                state = f"not forgotten ({' or '.join(new)} may be its new name)"
                note(f"{name}: {state}", quiet=options.quiet)
                continue
            forgotten.append(str(root / name))
            state = "forgotten" if is_written else "to forget"
            why = "there is no such file any more"
            if is_written and name not in known:
                state, why = "forgotten", "the lock knows it by its new name now"
            note(f"{name}: {state} ({why})", quiet=options.quiet)
    return forgotten


def _settle(done: Refreshed, path: Path, options: argparse.Namespace) -> bool:
    """Write or show what changed; return whether `--check` is to report it."""
    if done.lock is not None and not (options.check or options.diff):
        write_or_remove(controller_root(path) / LOCK_NAME, done.lock)
    if done.annotated is None:
        return False
    if options.diff and done.is_changed:
        print_diffs(done.annotated)
    if options.check or options.diff:
        return bool(options.check) and done.is_changed
    # Where blocks stay as they are, too: the run that is kept may have been another one.
    done.annotated.write()
    return False
