"""Which controllers a lock knows, and which of them depend on a file."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TypeVar

from tracerisk.adder.lock.digest import block_digests, digest_of
from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock, Lock, LockError, lock_key
from tracerisk.adder.sources.read import read_blocks
from tracerisk.adder.sources.renames import follow_renames
from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import controller_root, repository_above
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.pipeline.workspace.project import Project, Projects

T = TypeVar("T")

_MOST_FOLDERS = 20_000
_DIGEST = re.compile(rb"RiskAnnotation [0-9A-Za-z]{6}")
_OF_ALL = ("pyproject.toml", LOCK_NAME)  # what every controller of a root depends on


def controllers_of(files: Sequence[Path | str], projects: Projects) -> tuple[Path, ...]:
    """Return the controllers whose blocks or traces depend on any of the files, sorted.

    That are the files themselves where the lock knows them or they have blocks, and the
    controllers that import them; all of the lock for the settings or the lock itself, and all of
    the locks in and below a folder.
    A file that has to do with no controller adds none.
    Raises InputError for a file that is not there, or a lock that cannot be read.
    """
    paths: dict[Path, Path] = {}
    users_of: dict[Path, Mapping[str, Sequence[str]]] = {}
    for file in files:
        path = Path(file)
        if path.is_dir():
            inside = controllers_in(path, projects)
            if not inside:
                message = f"no {LOCK_NAME} in or below it knows a controller; name a controller"
                raise InputError(message, Location(str(path)))
            paths.update({controller.resolve(): controller for controller in inside})
            continue
        if not path.is_file():
            if not is_gone(path, projects):
                raise InputError("there is no such file; name a controller", Location(str(path)))
            paths[path.resolve()] = path
            continue
        project = projects.of(path)
        root = project.root
        if root not in users_of:
            users_of[root] = _users(project.lock)
        key = lock_key(path, root)
        users = users_of[root].get(key, ())
        if key in _OF_ALL:
            users = sorted(project.lock.controllers)
        for name in users:
            controller = path if name == key else _shown(root / name, path)
            paths.setdefault(controller.resolve(), controller)
        if not users and _is_source(path.name) and b"RiskAnnotation" in file_bytes(path):
            paths.setdefault(path.resolve(), path)
    return tuple(paths[item] for item in sorted(paths))


def _is_source(name: str) -> bool:
    return name.endswith(".py") or is_c(name)


def controllers_in(root: Path, projects: Projects) -> tuple[Path, ...]:
    """Return every controller of the locks in and below a folder, sorted, gone ones among them.

    Raises InputError where a lock cannot be read.
    """
    generator = (
        folder / key for folder, lock in locks_in(root, projects) for key in lock.controllers
    )
    return tuple(sorted(generator))


def named_or_all(files: Sequence[Path | str], projects: Projects) -> tuple[Path, ...]:
    """Return the controllers of the files; where none is named, all. Raises as either of both."""
    return controllers_of(files, projects) if files else all_controllers(projects)


def all_controllers(projects: Projects, *, with_unknown: bool = False) -> tuple[Path, ...]:
    """Return every controller of the locks in and below this folder: where no file is named.

    Where there is none, those of the lock of the project that this folder is part of. If asked,
    the `unknown_controllers` in this folder are among them.
    Raises InputError where that has none either; a hook of pre-commit lets a commit pass then.
    """
    controllers = controllers_in(Path(), projects)
    if not controllers:
        above = controllers_in(controller_root(Path("here.py")), projects)
        controllers = tuple(Path(os.path.relpath(path)) for path in above)
    if with_unknown:
        controllers = tuple(sorted({*controllers, *unknown_controllers(Path(), projects)}))
    if not controllers and not os.environ.get("PRE_COMMIT"):
        raise InputError(f"no {LOCK_NAME} in or below this folder knows a controller; name a FILE")
    return controllers


def lock_folders(root: Path) -> Iterator[Path]:
    """Yield the folders in and below one that have a lock; hidden ones and packages left out."""
    for folder, files in _folders(root):
        if LOCK_NAME in files:
            yield folder


def _folders(root: Path) -> Iterator[tuple[Path, Sequence[str]]]:
    """Yield the folders in and below one with the names of their files.

    Environments are left out, and so are clones of other repositories inside of one.
    """
    is_in_repository = repository_above(root / LOCK_NAME) is not None
    for number, (folder, folders, files) in enumerate(islice(os.walk(root), _MOST_FOLDERS)):
        if number and is_in_repository and ".git" in folders:
            folders.clear()
            continue
        folders[:] = sorted(
            name for name in folders if not name.startswith(".") and name != "node_modules"
        )
        if "pyvenv.cfg" in files:
            folders.clear()
        else:
            yield Path(folder), files


def unknown_controllers(root: Path, projects: Projects) -> tuple[Path, ...]:
    """Return the sources in and below a folder with blocks that no run wrote there, sorted.

    These are the ones that no lock knows beside a lock, or with the digest of a run elsewhere.
    Raises InputError where a lock cannot be read.
    """
    return tuple(
        sorted(
            folder / name
            for folder, files in _folders(root)
            for name in files
            if _is_source(name) and _is_unknown(folder / name, projects)
        )
    )


def _is_unknown(path: Path, projects: Projects) -> bool:
    try:
        source = file_bytes(path) if path.is_file() and not path.is_symlink() else b""
    except OSError:
        return False  # whose file it is has to make it readable
    if b"RiskAnnotation" not in source:
        return False
    project = projects.of(path)
    key = lock_key(path, project.root)
    lock = project.lock
    if any(key == name or key in entry.blocks for name, entry in lock.controllers.items()):
        return False
    try:
        blocks = read_blocks(source, str(path))
    except TraceRiskError:
        return False  # it is no controller that could run
    return bool(blocks) and (bool(lock.controllers) or has_digest(source))


def has_digest(source: bytes) -> bool:
    """Return whether a source has a block that tracerisk wrote, here or elsewhere."""
    return _DIGEST.search(source) is not None


def locks_in(root: Path, projects: Projects) -> Iterator[tuple[Path, Lock]]:
    """Yield the locks in and below a folder, each with its folder.

    Raises LockError where one cannot be read.
    """
    for folder in lock_folders(root):
        try:
            yield folder, projects.at(folder).lock
        except LockError as error:
            line = None if error.location is None else error.location.line
            raise LockError(error.message, Location(str(folder / LOCK_NAME), line)) from error


def is_gone(path: Path, projects: Projects) -> bool:
    """Return whether a lock knows a controller at `path` and there is no file."""
    if path.is_file():
        return False
    project = projects.of(path)
    return lock_key(path, project.root) in project.lock.controllers


def forget_gone(root: Path, *, write: bool = True) -> tuple[str, ...]:
    """Take the controllers that are gone out of the lock in a folder; return their names.

    Without `write` the lock stays as it is. The last one takes the lock with it.
    Raises InputError where the lock cannot be read or written.
    """
    path = root / LOCK_NAME
    if not path.is_file():
        return ()
    from tracerisk.pipeline.history.file_lock import one_writer

    with one_writer(root):
        lock = Project(root).lock
        gone = tuple(key for key in sorted(lock.controllers) if not (root / key).is_file())
        if gone and write:
            for key in gone:
                lock = lock.without_controller(key)
            write_or_remove(path, lock)
    return gone


def forget_blocks(files: Sequence[Path]) -> dict[Path, tuple[str, ...]]:
    """Take the blocks of files that have none any more out of the locks that know them.

    A controller of which no block is left goes, and the last one takes the lock with it. Returned
    are the controllers that went, by lock.
    Raises InputError where a lock cannot be read or written.
    """
    from tracerisk.pipeline.history.file_lock import one_writer

    gone: dict[Path, tuple[str, ...]] = {}
    for root in dict.fromkeys(map(controller_root, files)):
        path = root / LOCK_NAME
        if not path.is_file():
            continue
        here = {lock_key(file, root) for file in files if controller_root(file) == root}
        with one_writer(root):
            lock = before = Project(root).lock
            for name, entry in before.controllers.items():
                left = {file: blocks for file, blocks in entry.blocks.items() if file not in here}
                if left == entry.blocks:
                    continue
                if any(left.values()):
                    lock = lock.with_controller(name, replace(entry, blocks=left, previous=None))
                else:
                    lock = lock.without_controller(name)
            if lock != before:
                write_or_remove(path, lock)
                gone[path] = tuple(sorted(before.controllers.keys() - lock.controllers.keys()))
    return gone


def moved_controllers(root: Path, projects: Projects) -> tuple[Path, ...]:
    """Return the sources in and below a folder that a lock knows by a name that is gone, sorted.

    Raises InputError where a lock cannot be read.
    """
    moved = []
    for path in unknown_controllers(root, projects):
        project = projects.of(path)
        with suppress(TraceRiskError):
            if moved_from(project.lock, load_controller(path, project)) is not None:
                moved.append(path)
    return tuple(moved)


def write_or_remove(path: Path, lock: Lock) -> None:
    """Write a lock; one that knows no controller any more is removed."""
    if lock.controllers:
        from tracerisk.adder.sources.write import FileWrite, write_all

        write_all([FileWrite(path, lock.dumps())])
    else:
        path.unlink(missing_ok=True)


def with_moved(lock: Lock, controller: Controller) -> Lock:
    """Return the lock with what it knows of a controller under the name that this has now.

    A controller that the lock does not know is a renamed one where exactly one that it knows is
    gone of whose blocks all or most stand in its file, or more of them than of any other. A block
    that is equal to one of a controller that is still there may be a copy of that one.
    """
    key = controller.file
    old = moved_from(lock, controller)
    if old is None:
        return lock
    entry = lock.controllers[old]

    def moved(values: Mapping[str, T]) -> dict[str, T]:
        return {key if name == old else name: value for name, value in values.items()}

    inputs = dict(entry.inputs)
    if isinstance(inputs.get("sources"), dict):
        inputs["sources"] = moved(inputs["sources"])
    previous = None if entry.previous is None else moved(entry.previous)
    new = replace(
        entry,
        blocks=moved(entry.blocks),
        previous=previous,
        inputs=inputs,
        behind=entry.behind._replace(functions=moved(entry.behind.functions)),
        kept=moved(entry.kept),
    )
    return lock.without_controller(old).with_controller(key, new)


def moved_from(lock: Lock, controller: Controller) -> str | None:
    """Return the name by which the lock knows a controller that was renamed; else `None`."""
    if controller.file in lock.controllers or not lock.controllers:
        return None
    gone = {
        key: entry.blocks.get(key, {})
        for key, entry in lock.controllers.items()
        if not (controller.root / key).is_file()
    }
    if not gone:
        return None
    there = lock.controllers.keys() - gone.keys()
    elsewhere = set().union(*(block_digests(lock.controllers[key]) for key in there))
    followed = follow_renames(controller.source, str(controller.path), ())
    digests = {placed.block.digest for placed in followed.placed}
    names = {placed.block.name for placed in followed.placed} | set(followed.renamed)
    fits = []
    for key, written in gone.items():
        held = {
            name: digest
            for name, block in written.items()
            if (digest := digest_of(block)) in digests
        }
        own = {name for name, digest in held.items() if digest not in elsewhere}
        known = own | (held.keys() & names)
        is_most = bool(own) and 2 * len(known) > len(written)
        if is_most or (written and names.issuperset(written)):
            fits.append((len(known), key))
    most = max((count for count, _ in fits), default=0)
    best = [key for count, key in fits if count == most]
    return best[0] if len(best) == 1 else None


def sources_with_blocks(
    controller: Controller, entry: ControllerLock | None
) -> tuple[dict[str, bytes], dict[str, str]]:
    """Return what each file of a controller holds that has or had blocks, and its path in messages.

    The script comes first; files that are gone are left out.
    """
    known = {} if entry is None else entry.blocks
    files = [controller.file, *sorted(set(known) - {controller.file})]
    files = [
        file for file in files if file == controller.file or controller.path_of(file).is_file()
    ]
    shown = {file: str(controller.path_of(file)) for file in files}
    return {file: controller.source_of(file) for file in files}, shown


def without_controllers(files: Sequence[Path | str], projects: Projects) -> tuple[str, ...]:
    """Return those of the files that have to do with no controller, in their order."""
    return tuple(str(file) for file in files if not controllers_of([file], projects))


def _users(lock: Lock) -> dict[str, list[str]]:
    """Return, for each file, the controllers that it is, or that depend on it."""
    users: dict[str, list[str]] = {}
    for name, entry in lock.controllers.items():
        inputs = RunInputs.from_data(entry.inputs)
        hardware = inputs.settings.get("hardware", name)
        for file in {name, hardware, *entry.blocks, *inputs.sources, *inputs.files}:
            users.setdefault(file, []).append(name)
    return users


def _shown(path: Path, like: Path) -> Path:
    return path if like.is_absolute() else Path(os.path.relpath(path))
