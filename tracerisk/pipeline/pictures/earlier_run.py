"""The run of an earlier revision, to show it beside the present one.

It is the one that the lock of that revision knows: from the cache, from a recording that the user
names, or run again in a folder of its own. The user's working tree is never touched.
"""

from __future__ import annotations

import os
import posixpath
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.common import trace_json
from tracerisk.common.dependencies import install_command, is_installed
from tracerisk.common.text.bounded import MOST_WRITTEN, file_text
from tracerisk.common.version import __version__
from tracerisk.errors import InputError, Location, LogError, readable
from tracerisk.pipeline.check.check import given_options
from tracerisk.pipeline.freshness.trace_cache import FOLDER, TraceCache
from tracerisk.pipeline.history.repository import SUBMODULE, SYMLINK, Repository
from tracerisk.pipeline.pictures.run_section import given_recording, packed_recording, run_again
from tracerisk.pipeline.review.controllers import Locks
from tracerisk.pipeline.review.git_versions import GitVersion, compared
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.pipeline.workspace.project import Project
from tracerisk.report.html.run.replay import RecordedRun, check_recording
from tracerisk.trace import Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.review.version_inputs import RunOfVersion
    from tracerisk.pipeline.run.ended_run import Progress


@dataclass(frozen=True, slots=True)
class RunOfRevision:
    """The run of a controller at an earlier revision."""

    version: str
    """The revision as the user named it."""
    trace: Trace
    """Its trace."""
    recorded: RecordedRun
    """What was recorded of it."""


class SourcesOfRevision(NamedTuple):
    """The sources of a controller at an earlier revision."""

    prefix: str
    """What stands before its files in places, such as `main:`."""
    sources: Mapping[str, bytes]
    """Those with blocks, by the names that a trace of it gives them."""


_TRACE = "trace.json"
"""How a trace is called that lies in the folder of its recording."""


def earlier_run(
    controller: Controller,
    revision: str,
    *,
    was: str | None = None,
    fingerprint: str = "",
    recording: Path | None = None,
    runs: bool = False,
    progress: Progress | None = None,
) -> RunOfRevision | str:
    """Return the run of a controller at a revision, or why there is none and what brings it.

    `was` is the controller's path there, from here, where it moved; `fingerprint` that of the
    present run. `recording` names the earlier one; if there is none, it `runs` again.
    Raises InputError for what git does not know, LogError for a recording that is not of that run,
    and as `trace_controller` where it runs.
    """
    here = Path.cwd()
    with Repository.opened(here) as repository:
        version = compared(repository, here, [revision]).before
        path = _path_in(repository, was or controller.path)
        run = Locks(version).run_of(path)
        if version.file(path) is None:
            return f"{version.name} has no {was or controller.path}."
        if run is not None and run.recorded.fingerprint == fingerprint and recording is None:
            return f"The run is that of {version.name}."
        known = _recorded(controller, version, run, recording)
        if isinstance(known, str) and runs and recording is None:
            with tempfile.TemporaryDirectory(prefix="tracerisk-") as folder:
                known = _run_again(controller, version, path, run, Path(folder), progress)
        if isinstance(known, str):
            return known
        trace, recorded = known
        check_recording(trace, recorded)
        return RunOfRevision(version.name, trace, recorded)


def earlier_sources(
    controller: Controller, revision: str, *, was: str | None = None
) -> SourcesOfRevision:
    """Return the sources of a controller at a revision; `was` is its path there, where it moved.

    Raises InputError for what git does not know.
    """
    here = Path.cwd()
    with Repository.opened(here) as repository:
        version = compared(repository, here, [revision]).before
        path = _path_in(repository, was or controller.path)
        run = Locks(version).run_of(path)
        root = posixpath.dirname(path) if run is None else run.folder
        return SourcesOfRevision(version.prefix, _sources(version, run, path, root))


def _path_in(repository: Repository, path: Path | str) -> str:
    """Return the path from the top of a repository of one that is meant from here."""
    return Path(os.path.relpath(Path.cwd().resolve() / path, repository.top.resolve())).as_posix()


def _recorded(
    controller: Controller, version: GitVersion, run: RunOfVersion | None, recording: Path | None
) -> tuple[Trace, RecordedRun] | str:
    """Return trace and recording of the run of a version, as they are kept or named."""
    print_, name = "" if run is None else run.recorded.fingerprint, version.name
    cache, file = TraceCache(controller.root), controller.file
    if run is not None:
        file = posixpath.relpath(run.controller, run.folder)
    if recording is not None:
        inside = recording.parent if recording.name == FOLDER else recording
        if (inside / FOLDER).is_dir():
            cache = TraceCache(inside)
        else:
            return _named_trace(recording, cache.read(print_, file), name), given_recording(
                recording
            )
    if run is None:
        return f"The lock of {name} knows no run of it. {_remedies(controller, name)}"
    trace, path = cache.read(print_, file), cache.replay_path(print_, file)
    if trace is None or not path.is_file():
        where = "on this machine" if recording is None else f"in {recording}"
        return f"The run of {name} is not kept {where}. {_remedies(controller, name)}"
    if not is_installed("numpy"):
        return f"It needs NumPy: `{install_command('large')}` brings it."
    try:
        return trace, packed_recording(path)
    except LogError as error:
        return f"The run of {name} cannot be read: {error}. {_remedies(controller, name)}"


def _remedies(controller: Controller, name: str) -> str:
    report = f"tracerisk report {controller.path} --against {name}"
    return (
        f"`{report} --run-against` runs it once more, in a folder of its own; "
        "`--against-recording PATH` names a recording, or the .tracerisk_cache of another machine."
    )


def _named_trace(recording: Path, kept: Trace | None, name: str) -> Trace:
    """Return the trace of a recording that the user names: beside it, or the kept one."""
    place = recording / _TRACE if recording.is_dir() else recording.with_suffix(".json")
    if place.is_file():
        with readable(place, LogError):
            return trace_json.loads(file_text(place, most=MOST_WRITTEN), str(place))
    if kept is None:
        raise InputError(
            f"no trace belongs to this recording of {name}; `tracerisk run FILE --keep DIR --trace "
            f"DIR/{_TRACE}` leaves both, and a .replay file needs its .json beside it",
            Location(str(recording)),
        )
    return kept


def _run_again(
    controller: Controller,
    version: GitVersion,
    path: str,
    run: RunOfVersion | None,
    folder: Path,
    progress: Progress | None,
) -> tuple[Trace, RecordedRun] | str:
    """Run a version's controller in a folder of its own, and keep the run as others are kept."""
    write_version(version, folder)
    top = version.repository.top.resolve()
    root = os.path.relpath(controller.root.resolve(), top) if run is None else run.folder
    earlier = load_controller(folder / path, Project(folder / root))
    settings = earlier.settings
    if run is not None:
        settings = settings.with_options(given_options(run.recorded, earlier))
    trace, recorded = run_again(earlier, settings, progress)
    if not trace.is_usable or recorded is None:
        return f"The run of {version.name} shows nothing: {trace.end.message}."
    if run is not None and run.recorded.settings.get("tracerisk") == __version__:
        TraceCache(controller.root).write(run.recorded.fingerprint, trace, is_last=False)
    return trace, recorded


def write_version(version: GitVersion, folder: Path) -> None:
    """Write the tracked files of a commit into a folder; links that lead out of it are left out.

    No filter of git runs on them, and submodules stay empty.
    """
    assert version.commit is not None, "the working tree is there already"
    listed = version.repository.output("ls-tree", "-r", "-z", version.commit)
    links: list[tuple[Path, str]] = []
    for row in listed.decode(errors="surrogateescape").split("\0"):
        head, _, name = row.partition("\t")
        if not name or {"..", ".git"} & set(PurePosixPath(name).parts) or name.startswith("/"):
            continue
        mode, _, blob = head.split(" ")
        content = None if mode == SUBMODULE else version.repository.blob(blob)
        if content is None:
            continue
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if mode == SYMLINK:
            links.append((place, content.decode(errors="surrogateescape")))
        else:
            place.write_bytes(content)
            place.chmod(0o755 if mode == "100755" else 0o644)
    for place, target in links:  # last, so that nothing is written through one
        goal = os.path.normpath(place.parent / target)
        if not Path(target).is_absolute() and Path(goal).is_relative_to(folder):
            place.symlink_to(target)


def _sources(
    version: GitVersion, run: RunOfVersion | None, path: str, root: str
) -> Mapping[str, bytes]:
    """Return the sources with blocks in a version, by the names that its trace gives them."""
    files = [posixpath.relpath(path, root)]
    if run is not None:
        files += [file for file, blocks in run.entry.blocks.items() if blocks]
    sources = {}
    for file in dict.fromkeys(files):
        content = version.file(posixpath.normpath(posixpath.join(root, file)))
        if content is not None:
            sources[file] = content
    return sources
