"""The commit that files are checked out from, and how they stand to it."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import NamedTuple

from tracerisk.common.record import Commit, FileState
from tracerisk.errors import InputError
from tracerisk.pipeline.history.repository import Repository

_COMMITTER = re.compile(rb"^committer .* (\d+) ([+-])(\d\d)(\d\d)$", re.MULTILINE)


class CheckedOut(NamedTuple):
    """What git says of some files."""

    commit: Commit
    """The commit that is checked out."""
    states: Mapping[Path, FileState]
    """How each file that was asked for stands to it."""


def checked_out(
    folder: Path, files: Sequence[Path], *, made: Collection[Path] = ()
) -> CheckedOut | str:
    """Return the commit of a folder and how files stand to it, or why there is none.

    Files that are `made` of the others, as a report is, do not count as changed.
    """
    try:
        with Repository.opened(folder) as repository:
            return _checked_out(repository, files, made)
    except InputError as error:
        return f"git names no commit: {error.message}"


def _checked_out(
    repository: Repository, files: Sequence[Path], made: Collection[Path]
) -> CheckedOut | str:
    head = repository.read("HEAD^{commit}")
    if head is None:
        return "the repository has no commit yet"
    top = repository.top.resolve()
    changed = {top / name for name in _changed(repository)}
    within = [path for path in files if path.resolve().is_relative_to(top)]
    tracked = _tracked(repository, top, within)
    left = changed - {path.resolve() for path in made}
    names = sorted(path.relative_to(top).as_posix() for path in left)
    states: dict[Path, FileState] = {}
    for path in files:
        real = path.resolve()
        states[path] = "not committed"
        if real in tracked:
            states[path] = "changed since" if real in changed else "as committed"
    return CheckedOut(Commit(head[0], _committed(head[2]), tuple(names)), states)


def _changed(repository: Repository) -> list[str]:
    """Return the tracked files that differ from the commit, in the index or the working tree."""
    asked = ("status", "--porcelain=v1", "-z", "--untracked-files=no", "--no-renames")
    listed = repository.output(*asked).decode(errors="surrogateescape")
    return [entry[3:] for entry in listed.split("\0") if entry]


def _tracked(repository: Repository, top: Path, files: Sequence[Path]) -> set[Path]:
    """Return which of the files the commit has, or the index is about to add."""
    if not files:
        return set()
    paths = [str(path.resolve()) for path in files]
    listed = repository.output("ls-files", "-z", "--", *paths)
    return {top / name for name in listed.decode(errors="surrogateescape").split("\0") if name}


def _committed(commit: bytes) -> str:
    """Return the committer's date of a commit object, as ISO 8601 has it."""
    matched = _COMMITTER.search(commit.partition(b"\n\n")[0])
    if matched is None:
        return "unknown"
    seconds, sign, hours, minutes = (part.decode() for part in matched.groups())
    offset = timedelta(hours=int(hours), minutes=int(minutes))
    zone = timezone(-offset if sign == "-" else offset)
    return (datetime.fromtimestamp(0, zone) + timedelta(seconds=int(seconds))).isoformat()
