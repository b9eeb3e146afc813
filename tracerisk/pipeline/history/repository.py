"""A git repository, read through git itself; nothing is ever written, not even its index."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from tracerisk.errors import InputError, Location
from tracerisk.pipeline.history.git import Objects, git, objects_read

SYMLINK, SUBMODULE = "120000", "160000"
_ABSENT = "000000"
_MOST_PATHS = 60_000  # characters of paths on a command line, well below what Linux takes


class ChangedFile(NamedTuple):
    """A file that differs between two versions, by its paths from the repository's top."""

    before: str | None
    """The path before; `None` where the version before lacks the file."""
    after: str | None
    """The path after; `None` where the version after lacks the file."""
    before_blob: str | None
    """The hash of the content before; `None` where it is in the working tree, or absent."""
    after_blob: str | None
    """The hash of the content after; `None` where it is in the working tree, or absent."""
    mode: str
    """The file mode in git, such as `100644`; of the version after, where it has the file."""


@dataclass(frozen=True, eq=False)
class Repository:
    """The repository of a folder, read by one git process, which `opened` ends."""

    top: Path
    """The top folder of its working tree."""
    is_shallow: bool
    """Whether older commits are missing from the clone."""
    _is_sparse: bool
    """Whether the working tree may leave files out."""
    _objects: Objects
    """What reads its objects."""

    @classmethod
    @contextmanager
    def opened(cls, folder: Path) -> Iterator[Repository]:
        """Yield the repository that the folder is in.

        Raises InputError where there is none, where it has no working tree, or without git.
        """
        asked = ("--is-shallow-repository", "--git-path", "info/sparse-checkout", "--show-toplevel")
        answer = git(folder, "rev-parse", *asked)
        if answer.returncode:
            raise InputError(_no_repository(answer.stderr), Location(str(folder)))
        output = answer.stdout.decode(errors="surrogateescape")
        shallow, sparse, top = output.split("\n", 2)
        path = Path(top.removesuffix("\n"))
        if not folder.resolve().is_relative_to(path.resolve()):
            raise InputError(
                f"is in a repository whose files are those of another folder, {path}; remove "
                "core.worktree from its .git/config",
                Location(str(folder)),
            )
        with objects_read(path) as objects:
            yield cls(path, shallow == "true", (folder / sparse).is_file(), objects)

    def read(self, name: str) -> tuple[str, str, bytes] | None:
        """Return the hash, the type and the content of an object; `None` where there is none.

        `name` is what git calls it: a hash, `HEAD^{commit}`, `HEAD:place.py`.
        """
        return self._objects.read(name)

    def file(self, commit: str, path: str) -> bytes | None:
        """Return the content of a file in a commit or tree; `None` where it is not a file there."""
        if "\n" not in path:
            return self.blob(f"{commit}:{path}")
        # Questions to git end at a line feed: what has one in its name is asked for by its hash.
        entry = self.output("ls-tree", "-z", "--", commit, path).partition(b"\t")[0].split(b" ")
        return self.blob(entry[2].decode()) if len(entry) == 3 else None

    def blob(self, name: str) -> bytes | None:
        """Return the content of a blob; `None` where there is none of this name."""
        row = self.read(name)
        return row[2] if row is not None and row[1] == "blob" else None

    def tree_of(self, commit: str) -> dict[str, tuple[str, str]]:
        """Return the mode and the hash of each file of a commit, by its path from the top."""
        listed = self.output("ls-tree", "-r", "-z", "--full-tree", commit)
        entries = {}
        for line in listed.decode(errors="surrogateescape").split("\0"):
            head, tab, path = line.partition("\t")
            if tab:
                mode, _, blob = head.split(" ")
                entries[path] = mode, blob
        return entries

    def left_out(self, path: str) -> bytes | None:
        """Return a file that a sparse checkout leaves out of the working tree; `None` for none.

        It counts as unchanged there, as git has it.
        """
        return self.blob(f":{path}") if path in self._skipped else None

    @cached_property
    def _skipped(self) -> frozenset[str]:
        if not self._is_sparse:
            return frozenset()
        listed = self.output("ls-files", "-t", "-z").decode(errors="surrogateescape")
        return frozenset(line[2:] for line in listed.split("\0") if line.startswith("S "))

    def merge_base(self, one: str, other: str) -> str | None:
        """Return the best common ancestor of two commits; `None` where they have none."""
        answer = git(self.top, "merge-base", one, other)
        return None if answer.returncode else answer.stdout.decode().strip() or None

    def empty_tree(self) -> str:
        """Return the name of the tree without files, for a repository without a commit."""
        return self.output("hash-object", "-t", "tree", "--stdin").decode().strip()

    def changed(self, before: str, after: str | None) -> list[ChangedFile]:
        """Return the tracked files that differ, renames not yet found.

        `after` is a commit, `None` for the working tree.
        """
        return _files(self.output(*_difference(before, after)))

    def renamed(self, before: str, after: str | None, paths: list[str]) -> list[ChangedFile]:
        """Return the files that differ among the paths, with renames."""
        short = paths if sum(map(len, paths)) + len(paths) < _MOST_PATHS else []
        return _files(self.output(*_difference(before, after), "-M", "--", *short))

    def output(self, verb: str, *arguments: str, given: bytes = b"") -> bytes:
        """Return what a git command that only reads prints; `given` is its standard input.

        Raises InputError where it fails.
        """
        answer = git(self.top, verb, *arguments, given=given)
        if answer.returncode:
            message = answer.stderr.decode(errors="replace").strip()
            raise InputError(f"git {verb} failed: {message}", Location(str(self.top)))
        return answer.stdout


def _difference(before: str, after: str | None) -> tuple[str, ...]:
    shared = ("--raw", "-z", "--no-abbrev")
    if after is None:
        return ("diff-index", *shared, before)
    return ("diff-tree", "-r", *shared, before, after)


def _files(raw: bytes) -> list[ChangedFile]:
    """Read what `--raw -z` prints: `:mode mode blob blob status`, then one path or two."""
    parts = iter(raw.decode(errors="surrogateescape").split("\0"))
    row: dict[tuple[str | None, str | None], ChangedFile] = {}
    for head in parts:
        if not head.startswith(":"):
            continue
        before_mode, after_mode, before_blob, after_blob, status = head[1:].split(" ")
        old = new = next(parts)
        if status[0] in "RC":
            new = next(parts)
        if status == "U":
            # An unmerged file is listed a second time, as what the working tree holds.
            continue
        before = None if before_mode == _ABSENT or status[0] == "C" else old
        after = None if after_mode == _ABSENT else new
        mode = before_mode if after is None else after_mode
        file = ChangedFile(before, after, _blob(before_blob), _blob(after_blob), mode)
        row[(before, after)] = file
    return list(row.values())


def _blob(name: str) -> str | None:
    return name if name.strip("0") else None


def _no_repository(output: bytes) -> str:
    text = output.decode(errors="replace").strip()
    if "not a git repository" in text:
        return "is in no git repository; versions are read from git: run it in a clone"
    if "work tree" in text or "bare repository" in text:
        return "is in a repository without a working tree; run it in a clone with one"
    return f"git cannot read the repository: {text}"
