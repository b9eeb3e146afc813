"""What a report says of an earlier revision: what changed, both runs in step, and both sources."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from tracerisk.cli.reporting.report_input import shown_sources
from tracerisk.cli.shared.progress import progress_bar
from tracerisk.errors import InputError
from tracerisk.pipeline.history.repository import Repository
from tracerisk.pipeline.pictures.earlier_run import earlier_run, earlier_sources
from tracerisk.pipeline.review.git_versions import compared
from tracerisk.pipeline.review.review import review
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.prm.review.risk_diff import Review
from tracerisk.report.html.report_input import ComparedSources, EarlierRun, SideBySide
from tracerisk.report.html.run.replay import RecordedRun


@dataclass(frozen=True, slots=True)
class Comparison:
    """The comparison of a report with the revision of `--against`."""

    options: argparse.Namespace
    """The options of the verb."""
    controller: Controller | None
    """The controller of the report; `None` where no source is Python."""
    review: Review
    """What changed in its files."""

    @classmethod
    def of(
        cls, options: argparse.Namespace, controller: Controller | None, files: Iterable[str]
    ) -> Comparison:
        """Compare files with the revision; raise as `review_against`."""
        return cls(options, controller, review_against(options.against, files))

    def both_runs(self, *, fingerprint: str, now: RecordedRun | str) -> SideBySide | str:
        """Return the run of the revision and the present one, to show in step, or why not.

        "" where no source is Python. `now` is what was recorded of the present run, or why nothing
        was. Raises as `earlier_run`.
        """
        options, controller = self.options, self.controller
        if controller is None:
            return ""
        if isinstance(now, str):
            return now or (
                "The present run is not kept on this machine: a .tracerisk_cache that holds it, as "
                "CI keeps one, brings it, and so do `--trace FILE` and `--recording PATH`."
            )
        given = getattr(options, "against_recording", None)
        runs = getattr(options, "run_against", False)
        duration_s, is_quiet = controller.settings.run_duration_s, options.quiet or not runs
        with progress_bar(duration_s, quiet=is_quiet) as bar:
            found = earlier_run(
                controller,
                _one_revision(options.against),
                was=self._was(controller),
                fingerprint=fingerprint,
                recording=None if given is None else Path(given),
                runs=runs,
                progress=bar,
            )
        if isinstance(found, str):
            return found
        return SideBySide(EarlierRun(self.review.before, found.trace, found.recorded), now)

    def sources(self, present: Mapping[str, bytes]) -> ComparedSources | None:
        """Return the sources of the revision and the present ones; `None` without a controller.

        `present` are sources by the names of their files. Raises as `earlier_sources`.
        """
        controller = self.controller
        if controller is None:
            return None
        revision = _one_revision(self.options.against)
        found = earlier_sources(controller, revision, was=self._was(controller))
        names = {str(controller.path_of(file)): file for file in (controller.file, *found.sources)}
        return ComparedSources(
            found.prefix,
            {source.name: source for source in shown_sources(found.sources)},
            {names[item.name]: item for item in shown_sources(present) if item.name in names},
        )

    def _was(self, controller: Controller) -> str | None:
        """Return the earlier path of a controller that moved."""
        here = os.path.relpath(controller.path)
        return next((diff.was for diff in self.review.controllers if diff.name == here), None)


def check_revision(text: str) -> None:
    """Raise InputError for what is no revision that git knows, for two, and for a file."""
    revision = _one_revision(text)
    with Repository.opened(Path.cwd()) as repository:
        if compared(repository, Path.cwd(), [revision]).paths is not None:
            raise InputError(f"--against takes a revision, and '{revision}' is a file")


def review_against(revision: str, files: Iterable[str]) -> Review:
    """Return what changed in files since one revision.

    Of A...HEAD the versions have the names that `tracerisk diff A...HEAD` gives them, and where
    the files are those of HEAD it is the same review.
    Raises InputError for what is no revision that git knows, and for two revisions.
    """
    base, paths = _one_revision(revision), [str(Path(file)) for file in files]
    if base == revision:
        return review([revision, *paths])
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
