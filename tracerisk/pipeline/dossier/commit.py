"""The commit that files are checked out from, and how they stand to it."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterator, Mapping
from datetime import datetime, timedelta, timezone
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from tracerisk.common.record import Commit, FileState
from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import InputError
from tracerisk.pipeline.history.repository import SYMLINK, Repository

_COMMITTER = re.compile(rb"^committer .* (\d+) ([+-])(\d\d)(\d\d)$", re.MULTILINE)
_MOST_LINKS = 40  # as many as Linux follows


class CheckedOut(NamedTuple):
    """What git says of some files."""

    commit: Commit
    """The commit that is checked out."""
    states: Mapping[Path, FileState]
    """How each file that was asked for stands to it."""


def checked_out(
    folder: Path, files: Mapping[Path, bytes], *, made: Collection[Path] = ()
) -> CheckedOut | str:
    """Return the commit of a folder and how files stand to it, or why there is none.

    `files` have the bytes that count. They are compared with the commit's own: what git says of a
    file can be switched off (`--assume-unchanged`, `--skip-worktree`, attributes).
    Files that are `made` of the others, as a report is, do not count as changed.
    """
    try:
        with Repository.opened(folder) as repository:
            return _checked_out(repository, files, made)
    except InputError as error:
        return f"git names no commit: {error.message}"


def _checked_out(
    repository: Repository, files: Mapping[Path, bytes], made: Collection[Path]
) -> CheckedOut | str:
    head = repository.read("HEAD^{commit}")
    if head is None:
        return "the repository has no commit yet"
    tree = _Tree(repository, repository.top.resolve(), repository.tree_of(head[0]))
    compared = {path: tree.compared(path, data) for path, data in files.items()}
    changed = {place for state, place in compared.values() if state == "changed since"}
    changed |= {*_changed(tree)} - {str(_within(tree.top, path.resolve())) for path in made}
    states = {path: state for path, (state, _) in compared.items()}
    return CheckedOut(Commit(head[0], _committed(head[2]), tuple(sorted(changed))), states)


class _Tree(NamedTuple):
    """The files of a commit."""

    repository: Repository
    """The repository that has it."""
    top: Path
    """The top folder of the working tree, without symbolic links."""
    entries: Mapping[str, tuple[str, str]]
    """The mode and the hash of each file, by its path from the top."""

    def compared(self, path: Path, data: bytes) -> tuple[FileState, str]:
        """Return how a file with these bytes stands to the commit, and the path that decides it.

        A symbolic link must be the commit's own too, and so must what it leads to.
        """
        place = _within(self.top, path)
        for _ in range(_MOST_LINKS):
            link = None if place is None else self._first_link(place)
            if place is None or link is None:
                break
            # As it stands: `Path.readlink` leaves out a `./` that is in the commit.
            target = os.readlink(self.top / link)  # noqa: PTH115
            if not self._holds(link, os.fsencode(target), is_link=True):
                return self._other(link)
            place = _within(self.top, self.top / link.parent / target / place.relative_to(link))
        if place is None:
            return "not committed", ""
        return ("as committed", str(place)) if self._holds(place, data) else self._other(place)

    def _other(self, place: PurePosixPath) -> tuple[FileState, str]:
        return "changed since" if str(place) in self.entries else "not committed", str(place)

    def _first_link(self, place: PurePosixPath) -> PurePosixPath | None:
        """Return the first symbolic link on the way to a place."""
        ways = (*reversed(place.parents), place)
        return next((way for way in ways if (self.top / way).is_symlink()), None)

    def _holds(self, place: PurePosixPath, data: bytes, *, is_link: bool = False) -> bool:
        mode, blob = self.entries.get(str(place), ("", ""))
        return (mode == SYMLINK) == is_link and self.repository.blob(blob) == data


def _within(top: Path, path: Path) -> PurePosixPath | None:
    """Return the path of a file from the top, `None` for one outside; links stay in it."""
    plain = Path(os.path.normpath(path))
    roots = (parent for parent in plain.parents if top in (parent, parent.resolve()))
    root = next(roots, None)
    return None if root is None else PurePosixPath(plain.relative_to(root).as_posix())


def _changed(tree: _Tree) -> Iterator[str]:
    """Yield the tracked files that differ from the commit, in the index or the working tree."""
    asked = ("status", "--porcelain=v1", "-z", "--untracked-files=no", "--no-renames")
    for entry in _split(tree.repository.output(*asked)):
        yield entry[3:]
    # Of these git does not say it: the flag of what is taken as unchanged is a small letter.
    for flag, _, name in (
        line.partition(" ") for line in _split(tree.repository.output("ls-files", "-v", "-z"))
    ):
        path = tree.top / name
        if (flag.islower() or flag == "S") and path.is_file():
            try:
                state, place = tree.compared(path, file_bytes(path))
            except OSError:
                yield name  # what cannot be read cannot be compared
                continue
            if state == "changed since":
                yield place


def _split(listed: bytes) -> list[str]:
    return [part for part in listed.decode(errors="surrogateescape").split("\0") if part]


def _committed(commit: bytes) -> str:
    """Return the committer's date of a commit object, as ISO 8601 has it."""
    matched = _COMMITTER.search(commit.partition(b"\n\n")[0])
    if matched is None:
        return "unknown"
    seconds, sign, hours, minutes = (part.decode() for part in matched.groups())
    offset = timedelta(hours=int(hours), minutes=int(minutes))
    zone = timezone(-offset if sign == "-" else offset)
    return (datetime.fromtimestamp(0, zone) + timedelta(seconds=int(seconds))).isoformat()
