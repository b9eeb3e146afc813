"""The two versions that a review compares: commits, or a commit and the working tree."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, Protocol

from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes, in_folder
from tracerisk.errors import InputError, Location, TraceRiskError, readable
from tracerisk.pipeline.history.repository import Repository

WORKING_TREE = "working tree"


@dataclass(frozen=True, slots=True)
class GitVersion:
    """One version of a repository's files."""

    repository: Repository = field(repr=False, compare=False)
    """The repository with all its versions."""
    name: str
    """The name of the version in messages."""
    prefix: str
    """What stands before its files in places, such as `main:`; empty for the working tree."""
    commit: str | None
    """The hash of the commit; `None` for the working tree."""

    def file(self, path: str) -> bytes | None:
        """Return the content of a file, by its path from the top; `None` where it has none.

        A symbolic link of the working tree is not a file of its own.
        Raises InputError when it cannot be read.
        """
        if self.commit is not None:
            return self.repository.file(self.commit, path)
        place = self.repository.top / path
        if place.is_symlink() or not place.is_file():
            return None if os.path.lexists(place) else self.repository.left_out(path)
        with readable(path):
            return file_bytes(place, MOST_WRITTEN)

    def names_in(self, folder: str) -> list[str]:
        """Return the paths, from the top, of what is in a folder; its name is empty for the top."""
        if self.commit is None:
            return [f"{folder}/{name}".lstrip("/") for name in self._listed(folder)]
        below = (f"{folder}/",) if folder else ()
        raw = self.repository.output("ls-tree", "--name-only", "-z", "--", self.commit, *below)
        return [name for name in raw.decode(errors="surrogateescape").split("\0") if name]

    def _listed(self, folder: str) -> list[str]:
        return [path.name for path in in_folder(self.repository.top / folder)]

    def tracked(self) -> list[str]:
        """Return the paths of all files that git knows in the version."""
        words: tuple[str, ...] = ("ls-files", "-z")
        if self.commit is not None:
            words = ("ls-tree", "-r", "--name-only", "-z", self.commit)
        raw = self.repository.output(*words).decode(errors="surrogateescape")
        return [name for name in raw.split("\0") if name]


class Compared(NamedTuple):
    """The two versions that are compared."""

    before: GitVersion
    """The earlier version."""
    after: GitVersion
    """The later version."""
    paths: tuple[str, ...] | None
    """The paths from the top to which the review is narrowed; `None` for all."""
    tip: GitVersion | None = None
    """The branch that the earlier version is the merge base of; `None` where that is its tip."""


def compared(repository: Repository, folder: Path, words: Sequence[str]) -> Compared:
    """Read `[REV[..REV]] [FILE...]` as git does.

    The first word is a revision unless it names a file.
    Raises InputError for a revision or a file that is not there, or a word that is both.
    """
    spec, files = _split(repository, folder, list(words))
    before, after, tip = _versions(repository, spec)
    if not files:
        return Compared(before, after, None, tip)
    paths = tuple(dict.fromkeys(_path(repository, folder, word) for word in files))
    for path, word in zip(paths, files, strict=False):
        _check_file(repository, path, word, (before, after))
    return Compared(before, after, paths, tip)


class NamedVersion(Protocol):
    """What messages need to know of a version: its name, and what stands before its files."""

    @property
    def name(self) -> str:
        """What messages call it."""

    @property
    def prefix(self) -> str:
        """What stands before its files in places."""


def in_version(error: TraceRiskError, version: NamedVersion) -> InputError:
    """Return the error with the version that it is about."""
    place = error.location
    if place is not None and version.prefix:
        place = Location(f"{version.prefix}{place.file}", place.line, place.column)
    return InputError(f"in {version.name}: {error.message}", place)


def _split(repository: Repository, folder: Path, words: list[str]) -> tuple[str | None, list[str]]:
    if not words:
        return None, []
    first = words[0]
    if first in (".", "..") or first.startswith(("./", "../", "/")):
        return None, words
    is_file = os.path.lexists(folder / first)
    parts = [part for part in _parts(first) if part is not None]
    is_revision = all(_commit(repository, part) is not None for part in parts)
    if is_file and is_revision:
        raise InputError(
            f"'{first}' is both a revision and a file; write ./{first} for the file, or "
            f"{first}^0 for the revision"
        )
    if is_file:
        return None, words
    if not is_revision and ".." not in first and _is_known(repository, folder, first):
        return None, words
    return first, words[1:]


def _is_known(repository: Repository, folder: Path, word: str) -> bool:
    """Return whether a word that is neither file nor revision is a file that git knew."""
    path = os.path.relpath(folder / word, repository.top)
    return any(repository.read(f"{tree}:{path}") is not None for tree in ("", "HEAD"))


def _parts(spec: str) -> tuple[str, str | None]:
    """Return the two revisions of a range, HEAD for one left out; the second `None` for one."""
    for dots in ("...", ".."):
        one, text, other = spec.partition(dots)
        if text:
            return one or "HEAD", other or "HEAD"
    return spec, None


def _versions(
    repository: Repository, spec: str | None
) -> tuple[GitVersion, GitVersion, GitVersion | None]:
    tree = GitVersion(repository, WORKING_TREE, "", None)
    one, other = _parts("HEAD" if spec is None else spec)
    if other is None:
        return _version(repository, one), tree, None
    before, after = _version(repository, one), _version(repository, other)
    if spec is not None and "..." in spec:
        base = repository.merge_base(str(before.commit), str(after.commit))
        if base is None:
            raise InputError(
                f"{one} and {other} have no common ancestor{_shallow(repository)}; write "
                f"{one}..{other} to compare them as they are"
            )
        tip = None if base == before.commit else before
        name = f"{one} (merge base)"
        return GitVersion(repository, name, f"{base[:10]}:", base), after, tip
    return before, after, None


def _version(repository: Repository, revision: str) -> GitVersion:
    commit = _commit(repository, revision)
    if commit is not None:
        # What nobody can distinguish by eye, as a CI job gives it, needs no 40 digits.
        name = revision[:10] if revision == commit else revision
        return GitVersion(repository, name, f"{name}:", commit)
    if revision == "HEAD":
        name = "HEAD, which has no commit yet"
        return GitVersion(repository, name, "HEAD:", repository.empty_tree())
    raise InputError(
        f"'{revision}' is not a revision here, and no file{_shallow(repository)}; allowed: what "
        "`git rev-parse` knows, A..B, A...B, and files"
    )


def _shallow(repository: Repository) -> str:
    if not repository.is_shallow:
        return ""
    return " (this clone is shallow: `git fetch --unshallow`, or fetch that revision)"


def _commit(repository: Repository, revision: str) -> str | None:
    # A name with a colon is that of a file in a revision.
    row = repository.read(f"{revision}^{{commit}}") if ":" not in revision else None
    return None if row is None else row[0]


def _path(repository: Repository, folder: Path, word: str) -> str:
    """Return a file's path from the top; its own folder is resolved, and not the file."""
    given = Path(os.path.normpath(folder / word))
    whole = given.parent.resolve() / given.name if given.name else given.resolve()
    try:
        path = whole.relative_to(repository.top.resolve())
    except ValueError as error:
        raise InputError(
            f"is outside the repository {repository.top}; run `tracerisk diff` in its own",
            Location(word),
        ) from error
    for parent in path.parents[:-1]:
        if (repository.top / parent / ".git").exists():
            raise InputError(
                f"is in another repository, {parent}; run `tracerisk diff` there", Location(word)
            )
    return path.as_posix()


def _check_file(
    repository: Repository, path: str, word: str, versions: tuple[GitVersion, GitVersion]
) -> None:
    if (repository.top / path).exists() and versions[1].commit is None:
        return
    for version in versions:
        tree = version.commit
        if tree is not None and repository.read(f"{tree}:{'' if path == '.' else path}"):
            return
    if _commit(repository, word) is not None:
        raise InputError(
            f"is a revision, and files come after the first; write {versions[0].name}..{word} to "
            "compare the two",
            Location(word),
        )
    names = " nor in ".join(version.name for version in versions)
    raise InputError(f"there is no such file in {names}; name a tracked one", Location(word))
