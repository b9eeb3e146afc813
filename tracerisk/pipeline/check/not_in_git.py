"""What a clone would lack: the lock of blocks that git tracks, or an input of their run."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock, lock_key
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.text.bounded import MOST_OF_A_RUN, file_bytes
from tracerisk.config import repository_above
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.pipeline.check.finding import CheckFinding
from tracerisk.pipeline.check.remedies import as_typed
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.workspace.project import Project, Projects

_MOST_NAMED = 3
_MOST_ASKED = 200


def untracked_findings(
    paths: Sequence[Path], projects: Projects
) -> Mapping[Path, tuple[CheckFinding, ...]]:
    """Return a finding for each controller whose blocks git tracks without what they rest on.

    One whose blocks are not staged or committed as they are here has none yet: who writes blocks
    adds the rest together with them. Without git, or a repository, nothing is found.
    """
    tops: dict[Path, list[Path]] = {}
    for path in paths:
        top = repository_above(path)
        if top is not None:
            tops.setdefault(top, []).append(path)
    findings: dict[Path, tuple[CheckFinding, ...]] = {}
    for top, controllers in tops.items():
        try:
            findings.update(_of_repository(top, controllers, projects))
        except (InputError, OSError):
            continue  # nothing is known of a repository that git cannot read
    return findings


def _of_repository(
    top: Path, controllers: Iterable[Path], projects: Projects
) -> Iterator[tuple[Path, tuple[CheckFinding, ...]]]:
    blobs = _tracked(top)
    lacking: dict[Path, list[str]] = {}
    for path in controllers:
        project = projects.of(path)
        entry = _entry(path, project)
        annotated = [path, *(project.root.resolve() / name for name in entry.blocks)]
        if all(file.is_file() and _is_kept(file, top, blobs) for file in annotated):
            names = (_from_top(file, top) for file in _inputs(project, entry))
            here = dict.fromkeys(name for name in names if name is not None and name not in blobs)
            lacking[path] = [file for file in here if not _is_of_another(top / file, top)]
    asked = sorted({file for files in lacking.values() for file in files})[:_MOST_ASKED]
    if not asked:
        return
    to_add = _not_ignored(top, asked)
    for path, files in lacking.items():
        # What is ignored is built or fetched again in a clone; a lock is not.
        lacks = [file for file in files if file in to_add or Path(file).name == LOCK_NAME]
        if lacks:
            yield path, (_finding(path, top, lacks, to_add),)


def _finding(path: Path, top: Path, names: Sequence[str], to_add: set[str]) -> CheckFinding:
    typed = [as_typed(top / name) for name in names]
    more = f" and {len(typed) - _MOST_NAMED} more" if len(typed) > _MOST_NAMED else ""
    message = f"git tracks the blocks, but not {', '.join(typed[:_MOST_NAMED])}{more}"
    force = "" if to_add.issuperset(names) else "--force "
    remedy = f"a clone would lack that: `git add {force}{' '.join(typed)}`"
    return CheckFinding("untracked", message, Location(str(path), 1), remedy=remedy)


def _entry(path: Path, project: Project) -> ControllerLock:
    try:
        entry = project.lock.controllers.get(lock_key(path, project.root))
    except TraceRiskError:
        entry = None  # a lock that cannot be read is said where it is read
    return ControllerLock("", {}) if entry is None else entry


def _inputs(project: Project, entry: ControllerLock) -> Iterator[Path]:
    """Yield the lock and what the blocks of a controller rest on, as far as it is there."""
    root = project.root.resolve()
    inputs = RunInputs.from_data(entry.inputs)
    prefixes = [Path(os.path.normpath(root / name)) for name in inputs.prefixes]
    named = [LOCK_NAME, *entry.blocks, *inputs.sources, *inputs.files]
    if inputs.evidence:
        named.append(EVIDENCE_NAME)
    files = [Path(os.path.normpath(root / name)) for name in named]
    hardware = inputs.settings.get("hardware")
    if isinstance(hardware, str):
        from tracerisk.common.hardware.source_files import source_files

        files += source_files(Path(os.path.normpath(root / hardware)))
    settings = root / "pyproject.toml"
    if settings.is_file() and b"[tool.tracerisk" in file_bytes(settings):
        files.append(settings)
    for file in files:
        if file.is_file() and not any(file.is_relative_to(prefix) for prefix in prefixes):
            yield file


def _from_top(path: Path, top: Path) -> str | None:
    """Return a path as git names it; `None` outside of the repository."""
    whole = path.parent.resolve() / path.name
    return whole.relative_to(top).as_posix() if whole.is_relative_to(top) else None


def _is_of_another(path: Path, top: Path) -> bool:
    """Return whether a file is in a repository or an environment inside of this repository."""
    between = [folder for folder in path.parents if folder != top and folder.is_relative_to(top)]
    return any((one / mark).exists() for one in between for mark in (".git", "pyvenv.cfg"))


def _tracked(top: Path) -> dict[str, str]:
    """Return the hash of each file in git's index: what the next commit holds."""
    blobs = {}
    for line in _ask(top, "--stage"):
        head, _, name = line.partition("\t")
        blobs[name] = head.split(" ")[1]
    return blobs


def _not_ignored(top: Path, names: Iterable[str]) -> set[str]:
    """Return which of the files that git does not track it does not ignore either."""
    return set(_ask(top, "--others", "--exclude-standard", "--", *names))


def _ask(top: Path, *arguments: str) -> list[str]:
    # Blocks are checked without git where there is no repository.
    from tracerisk.pipeline.history.git import git

    answer = git(top, "ls-files", "-z", *arguments)
    if answer.returncode:
        raise InputError("git cannot read the repository", Location(str(top)))
    return answer.stdout.decode(errors="surrogateescape").split("\0")[:-1]


def _is_kept(path: Path, top: Path, blobs: Mapping[str, str]) -> bool:
    """Return whether git's index has a file as it is here, but for the ends of its lines.

    Git itself would run filters of the repository for that.
    """
    blob = blobs.get(_from_top(path, top) or "")
    if blob is None:
        return False
    import hashlib

    data = file_bytes(path, MOST_OF_A_RUN)
    kind = "sha1" if len(blob) == 40 else "sha256"
    return any(
        hashlib.new(kind, b"blob %d\0" % len(text) + text, usedforsecurity=False).hexdigest()
        == blob
        for text in (data, data.replace(b"\r\n", b"\n"))
    )
