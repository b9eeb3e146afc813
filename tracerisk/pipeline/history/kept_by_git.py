"""What the versions of a source and of the lock that git keeps say of the source's blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.lock.digest import vouched_part
from tracerisk.adder.lock.lock import LOCK_NAME, LockError, WrittenBlock
from tracerisk.adder.lock.reading import loads
from tracerisk.adder.sources.read import read_blocks
from tracerisk.errors import InputError, TraceRiskError
from tracerisk.pipeline.history.repository import Repository

_MOST_COMMITS = 2000
_MOST_LOOSE = 20_000  # objects outside packs; git packs them at a third of that
_MOST_BYTES = 100_000_000
# Where git keeps the other side of what it is in the middle of.
_UNDER_WAY = ("MERGE_HEAD", "CHERRY_PICK_HEAD", "REVERT_HEAD", "REBASE_HEAD", "ORIG_HEAD")


@dataclass(slots=True)
class Kept:
    """What the versions of a file and of the lock that git keeps say of the file's blocks."""

    is_complete: bool = False
    """Whether all versions were read."""
    written: dict[str, list[WrittenBlock]] = field(default_factory=dict)
    """The blocks that tracerisk wrote, by the function's name, in all versions."""
    standing: dict[str, list[RiskBlock]] = field(default_factory=dict)
    """The blocks as they stood in the source, by the function's name, in all versions."""
    versions: set[frozenset[str]] = field(default_factory=set)
    """The functions with a block in each version of the source."""
    digests: set[frozenset[str]] = field(default_factory=set)
    """The digests of all blocks in each version of the source."""

    def add_source(self, content: bytes, file: str) -> None:
        """Add a version of the source; raises as `read_blocks` does."""
        blocks = [placed.block for placed in read_blocks(content, file)]
        self.versions.add(frozenset(block.name for block in blocks))
        self.digests.add(frozenset(block.digest for block in blocks if block.digest is not None))
        for block in blocks:
            self.standing.setdefault(block.name, []).append(block)
            part = vouched_part(block)
            if part is not None:
                self.written.setdefault(block.name, []).append(part)

    def add_lock(self, content: bytes, file: str) -> None:
        """Add a version of the lock; raises LockError where it is none."""
        # A file that was renamed, or copied, has another name there.
        for entry in loads(content, file).controllers.values():
            for blocks in entry.all_blocks:
                for written in blocks.values():
                    for name, block in written.items():
                        self.written.setdefault(name, []).append(block)


def kept_by_git(root: Path, file: str) -> Kept:
    """Return what git keeps of a file; nothing, and not complete, without a repository."""
    kept = Kept()
    try:
        with Repository.opened(root) as repository:
            _read_versions(repository, root, file, kept)
    except (InputError, OSError, ValueError):
        # No git, no repository, or one that cannot be read: nothing more is known then.
        kept.is_complete = False
    return kept


def _read_versions(repository: Repository, root: Path, file: str, kept: Kept) -> None:
    top = repository.top.resolve()
    source, lock = ((root / name).relative_to(top).as_posix() for name in (file, LOCK_NAME))
    blobs = _Blobs(repository)
    is_whole = not repository.is_shallow
    for path, add in ((source, kept.add_source), (lock, kept.add_lock)):
        versions, is_all = blobs.of(path)
        is_whole &= is_all and bool(versions)
        is_whole &= _add_all(repository, versions, path, add)
    kept.is_complete = is_whole


def _add_all(
    repository: Repository,
    blobs: Iterable[str],
    path: str,
    add: Callable[[bytes, str], None],
) -> bool:
    """Add every version that can be read; return whether that were all."""
    is_all, left = True, _MOST_BYTES
    for blob in blobs:
        content = repository.blob(blob) if left > 0 else None
        if content is None:
            is_all = False
            continue
        left -= len(content)
        try:
            add(content, path)
        except LockError:
            # A lock with a conflict in it says nothing that its sides do not.
            continue
        except TraceRiskError:
            is_all = False
    return is_all


class _Blobs:
    """Finds every version of a file that a repository keeps, whatever leads to it."""

    def __init__(self, repository: Repository) -> None:
        self._repository = repository
        self._loose, self._are_all_known = self._loose_commits()

    def of(self, path: str) -> tuple[list[str], bool]:
        """Return the names of the blobs, and whether these are all."""
        repository = self._repository
        under_way = [
            name for name in _UNDER_WAY if repository.read(f"{name}^{{commit}}") is not None
        ]
        log = repository.output(
            *("log", "--all", "--reflog", "--full-history", "-m", "--format=", "--raw", "-z"),
            *("--no-abbrev", "--no-renames", f"--max-count={_MOST_COMMITS}", *under_way),
            *("--", path),
        )
        # Each is `:mode mode blob blob status`, then the path.
        heads = [part for part in _texts(log) if part.lstrip("\n").startswith(":")]
        blobs = [name for head in heads for name in head.split(" ")[2:4]]
        staged = repository.output("ls-files", "-s", "-u", "-c", "-z", "--", path)
        blobs += [part.split(" ")[1] for part in _texts(staged) if part]
        for commit in self._loose:
            entry = repository.read(f"{commit}:{path}")
            if entry is not None and entry[1] == "blob":
                blobs.append(entry[0])
        names = [name for name in dict.fromkeys(blobs) if name.strip("0")]
        return names, self._are_all_known and len(heads) < _MOST_COMMITS

    def _loose_commits(self) -> tuple[list[str], bool]:
        """Return the commits outside packs: also those that nothing leads to any more.

        A stash that was dropped, what a rebase left behind without a reflog.
        """
        objects = self._repository.output("rev-parse", "--git-path", "objects")
        folder = self._repository.top / objects.decode(errors="surrogateescape").removesuffix("\n")
        names = list(_loose_objects(folder))
        if len(names) > _MOST_LOOSE:
            return [], False
        asked = ("--batch-check=%(objecttype) %(objectname)",)
        given = "\n".join(names).encode() + b"\n"
        decode = self._repository.output("cat-file", *asked, given=given).decode()
        lines = (line.split(" ") for line in decode.splitlines())
        return [name for kind, name, *_ in lines if kind == "commit"], True


def _loose_objects(folder: Path) -> Iterator[str]:
    for part in sorted(folder.glob("[0-9a-f][0-9a-f]")):
        yield from (part.name + path.name for path in sorted(part.iterdir()))


def _texts(output: bytes) -> list[str]:
    return output.decode(errors="surrogateescape").split("\0")
