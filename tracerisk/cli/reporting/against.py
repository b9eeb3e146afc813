"""`--against REV`: the difference to an earlier revision, for the verbs that write a report."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.cli.shared.progress import progress_bar
from tracerisk.common.dependencies import require_runs
from tracerisk.errors import InputError

# What a revision needs is imported where there is one: most runs are compared with none.
if TYPE_CHECKING:
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.prm.review.risk_diff import Review
    from tracerisk.report.html.report_input import ComparedSources, SideBySide
    from tracerisk.report.html.run.replay import RecordedRun


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


def both_runs(
    options: argparse.Namespace,
    controller: Controller | None,
    *,
    review: Review | None,
    fingerprint: str = "",
    now: RecordedRun | str,
) -> SideBySide | str:
    """Return the run of `--against` and the present one, to show in step, or why not.

    "" where none is asked for, or no source is Python. `now` is what was recorded of the present
    run, or why nothing was. Raises as `earlier_run`.
    """
    if review is None or controller is None:
        return ""
    if isinstance(now, str):
        return now or (
            "The present run is not kept on this machine: a .tracerisk_cache that holds it, as CI "
            "keeps one, brings it, and so do `--trace FILE` and `--recording PATH`."
        )
    from tracerisk.pipeline.pictures.earlier_run import earlier_run
    from tracerisk.report.html.report_input import EarlierRun, SideBySide

    given = getattr(options, "against_recording", None)
    runs = getattr(options, "run_against", False)
    with progress_bar(controller.settings.run_duration_s, quiet=options.quiet or not runs) as bar:
        found = earlier_run(
            controller,
            _one_revision(options.against),
            was=_was(controller, review),
            fingerprint=fingerprint,
            recording=None if given is None else Path(given),
            runs=runs,
            progress=bar,
        )
    if isinstance(found, str):
        return found
    return SideBySide(EarlierRun(review.before, found.trace, found.recorded), now)


def compared_sources(
    options: argparse.Namespace,
    controller: Controller | None,
    *,
    review: Review | None,
    sources: Mapping[str, bytes],
) -> ComparedSources | None:
    """Return the sources at `--against` and the present ones; `None` where none are asked for.

    `sources` are the present ones by the names of their files. Raises as `earlier_sources`.
    """
    if review is None or controller is None:
        return None
    from tracerisk.cli.reporting.report_input import shown_sources
    from tracerisk.pipeline.pictures.earlier_run import earlier_sources
    from tracerisk.report.html.report_input import ComparedSources

    found = earlier_sources(
        controller, _one_revision(options.against), was=_was(controller, review)
    )
    names = {str(controller.path_of(file)): file for file in (controller.file, *found.sources)}
    return ComparedSources(
        found.prefix,
        {source.name: source for source in shown_sources(found.sources)},
        {names[source.name]: source for source in shown_sources(sources) if source.name in names},
    )


def _was(controller: Controller, review: Review) -> str | None:
    """Return the earlier path of a controller that moved."""
    here = os.path.relpath(controller.path)
    return next((diff.was for diff in review.controllers if diff.name == here), None)


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
    revision = _one_revision(options.against)
    from tracerisk.pipeline.history.repository import Repository
    from tracerisk.pipeline.review.git_versions import compared

    with Repository.opened(Path.cwd()) as repository:
        if compared(repository, Path.cwd(), [revision]).paths is not None:
            raise InputError(f"--against takes a revision, and '{revision}' is a file")


def review_against(revision: str | None, files: Iterable[str]) -> Review | None:
    """Return what changed in files since one revision; `None` without it.

    Of A...HEAD the versions have the names that `tracerisk diff A...HEAD` gives them, and where
    the files are those of HEAD it is the same review.
    Raises InputError for what is no revision that git knows, and for two revisions.
    """
    if revision is None:
        return None
    from tracerisk.pipeline.review.review import review

    base, paths = _one_revision(revision), [str(Path(file)) for file in files]
    if base == revision:
        return review([revision, *paths])
    from tracerisk.pipeline.history.repository import Repository

    with Repository.opened(Path.cwd()) as repository:
        is_clean = not repository.output("status", "--porcelain", "--untracked-files=no")
    if is_clean:
        return review([revision, *paths])
    return replace(review([base, *paths]), before=f"{revision.partition('...')[0]} (merge base)")


def _one_revision(revision: str) -> str:
    """Return the revision that the sources as they are now are compared with.

    Of A...HEAD it is the merge base, as git has it: what A gained since is no change of a branch.
    Raises InputError for two revisions.
    """
    one, dots, _ = revision.partition("...")
    if dots:
        from tracerisk.pipeline.history.repository import Repository
        from tracerisk.pipeline.review.git_versions import compared

        with Repository.opened(Path.cwd()) as repository:
            what = compared(repository, Path.cwd(), [revision])
            head = compared(repository, Path.cwd(), ["HEAD"]).before
        if what.after.commit == head.commit:
            return str(what.before.commit)
    elif ".." not in revision:
        return revision
    raise InputError(
        f"--against takes one revision, which the sources as they are now are compared with; "
        f"'{revision}' names two; write {one.partition('..')[0] or 'main'}...HEAD for what a "
        "branch changed since it left another"
    )
