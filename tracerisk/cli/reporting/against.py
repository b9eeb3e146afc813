"""`--against REV`: the difference to an earlier revision, for the verbs that write a report."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.errors import InputError
from tracerisk.pipeline.history.repository import Repository
from tracerisk.pipeline.review.git_versions import compared

if TYPE_CHECKING:
    from tracerisk.prm.review.change_records import Review


def add_against(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    parser.add_argument(
        "--against", metavar="REV", help="show the difference to this git revision in the report"
    )


def check_against(options: argparse.Namespace) -> None:
    """Raise before a run what would keep its report from showing the difference.

    Raises InputError where the option has nothing to go with, or git does not know the revision.
    """
    revision = options.against
    if revision is None:
        return
    if options.report is None:
        raise InputError("--against goes with --report; add it, or ask `tracerisk diff`")
    if options.check or options.diff:
        given = "--check" if options.check else "--diff"
        raise InputError(
            f"--against compares with the sources as the run writes them, and {given} writes none"
        )
    _forbid_two_revisions(revision)

    with Repository.opened(Path.cwd()) as repository:
        if compared(repository, Path.cwd(), [revision]).paths is not None:
            raise InputError(f"--against takes a revision, and '{revision}' is a file")


def review_against(revision: str | None, files: Iterable[str]) -> Review | None:
    """Return what changed in files since a revision; `None` without one.

    Raises InputError for what is not one revision that git knows.
    """
    if revision is None:
        return None
    _forbid_two_revisions(revision)
    from tracerisk.pipeline.review.review import review

    return review([revision, *(str(Path(file)) for file in files)])


def _forbid_two_revisions(revision: str) -> None:
    if ".." in revision:
        raise InputError(
            f"--against takes one revision, which the sources as they are now are compared with; "
            f"'{revision}' names two"
        )
