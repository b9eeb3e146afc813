"""Which files a review looks at: those with risk blocks that differ between two versions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath
from typing import NamedTuple

from tracerisk.adder.lock.lock import LOCK_NAME
from tracerisk.errors import InputError, Location
from tracerisk.instrument.source.language import is_c_like
from tracerisk.pipeline.history.repository import SUBMODULE, SYMLINK, ChangedFile, Repository
from tracerisk.pipeline.review.git_versions import Compared, GitVersion


class AnnotatedFiles(NamedTuple):
    """The annotated files that a review is about."""

    pairs: tuple[tuple[str | None, str | None], ...]
    """The path from the top in both versions; `None` where a version lacks the file."""
    renames: Mapping[str, str]
    """The later path of each file that moved, by its earlier one."""
    notes: tuple[str, ...]
    """Sentences on what was left out."""
    lock_folders: tuple[str, ...] = ()
    """The folders of the locks that changed."""
    changed: frozenset[str] = frozenset()
    """The paths of all files that changed."""
    locks: tuple[str, ...] = ()
    """The folders of all locks of the later version."""


def annotated_files(
    repository: Repository, what: Compared, *, with_others: bool = False
) -> AnnotatedFiles:
    """Return the annotated sources that changed, or are named; of named folders, those in them.

    If asked, all locks are among what is returned, even where no file changed.
    Raises InputError where git or a file cannot be read.
    """
    later = what.after.commit
    changed = repository.changed(str(what.before.commit), later)
    notes = tuple(
        f"{file.after or file.before} is a submodule; run `tracerisk diff` in it"
        for file in changed
        if file.mode == SUBMODULE and _is_within(file, what.paths)
    )
    plain = [file for file in changed if _may_hold_blocks(file)]
    held = [file for file in plain if _is_annotated_somewhere(file, what)]
    renames = _renames(repository, what, held)
    pairs = [(file.before, file.after) for file in held if _is_within(file, what.paths)]
    pairs += _named(what, {path for pair in pairs for path in pair if path is not None})
    locks = tuple(
        str(PurePosixPath(file.after).parent)
        for file in changed
        if file.after is not None and PurePosixPath(file.after).name == LOCK_NAME
    )
    touched = frozenset(
        path
        for file in changed
        if file.mode not in (SYMLINK, SUBMODULE)
        for path in (file.before, file.after)
        if path is not None
    )
    all_locks = tuple(_folders_of_locks(what.after)) if touched or with_others else ()
    return AnnotatedFiles(tuple(_joined(pairs, renames)), renames, notes, locks, touched, all_locks)


def _folders_of_locks(version: GitVersion) -> Iterator[str]:
    for path in sorted(version.tracked()):
        if PurePosixPath(path).name == LOCK_NAME:
            yield str(PurePosixPath(path).parent)


def is_annotated(path: str, content: bytes | None) -> bool:
    """Return whether a file holds risk blocks, as far as its bytes and its name show."""
    if content is None or (b"RiskAnnotation" not in content and b"@Function" not in content):
        return False
    return bool(PurePosixPath(path).suffix) or content.startswith(b"#!")


def _is_source(path: str) -> bool:
    # Nodes of ROS 1 are often scripts without an ending.
    return PurePosixPath(path).suffix in ("", ".py") or is_c_like(path)


def _may_hold_blocks(file: ChangedFile) -> bool:
    if file.mode in (SYMLINK, SUBMODULE):
        return False
    return any(_is_source(path) for path in (file.before, file.after) if path is not None)


def _is_annotated_somewhere(file: ChangedFile, what: Compared) -> bool:
    """Return whether a file has blocks in a version, and other bytes in the other."""
    contents = [
        None if path is None else _content(version, path, blob)
        for version, path, blob in (
            (what.before, file.before, file.before_blob),
            (what.after, file.after, file.after_blob),
        )
    ]
    paths = file.before, file.after
    return contents[0] != contents[1] and any(
        path is not None and is_annotated(path, content)
        for path, content in zip(paths, contents, strict=True)
    )


def _content(version: GitVersion, path: str, blob: str | None) -> bytes | None:
    if blob is None or version.commit is None:
        return version.file(path)
    content = version.repository.blob(blob)
    if content is None:
        raise InputError(
            f"in {version.name}: git cannot read its content, {blob}; `git fsck` reports what is "
            "wrong, in a partial clone `git fetch` may bring it",
            Location(f"{version.prefix}{path}"),
        )
    return content


def _renames(repository: Repository, what: Compared, held: list[ChangedFile]) -> dict[str, str]:
    gone = [file.before for file in held if file.after is None and file.before is not None]
    new = [file.after for file in held if file.before is None and file.after is not None]
    if not gone or not new:
        return {}
    changed_files = repository.renamed(str(what.before.commit), what.after.commit, [*gone, *new])
    return {
        file.before: file.after
        for file in changed_files
        if file.before in gone and file.after in new and file.before is not None and file.after
    }


def _is_within(file: ChangedFile, paths: tuple[str, ...] | None) -> bool:
    return any(path is not None and is_within(path, paths) for path in (file.before, file.after))


def is_within(path: str, paths: tuple[str, ...] | None) -> bool:
    """Return whether a review that is narrowed to paths looks at one; `None` stands for all."""
    if paths is None:
        return True
    return any(base == "." or path == base or path.startswith(f"{base}/") for base in paths)


def _named(what: Compared, known: set[str]) -> Iterator[tuple[str | None, str | None]]:
    """Yield the named files that git does not report as changed: untracked or unchanged ones."""
    for path in what.paths or ():
        contents = [version.file(path) for version in (what.before, what.after)]
        if path in known or not any(is_annotated(path, content) for content in contents):
            continue
        before, after = (path if content is not None else None for content in contents)
        yield before, after


def _joined(
    pairs: list[tuple[str | None, str | None]], renames: Mapping[str, str]
) -> Iterator[tuple[str | None, str | None]]:
    """Yield the pairs, the two halves of each renamed file as one."""
    targets = set(renames.values())
    seen = set()
    was = {new: old for old, new in renames.items()}
    for before, after in pairs:
        pair = before, after
        if after is None and before is not None and before in renames:
            pair = before, renames[before]
        elif before is None and after in targets:
            pair = was[str(after)], after
        if pair not in seen:
            seen.add(pair)
            yield pair
