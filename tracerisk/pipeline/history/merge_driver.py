"""Merge `tracerisk.lock` for git controller by controller, and not line by line.

The attribute is committed with the repository; the driver is a matter of each clone. Where it is
not set up, or tracerisk is not at hand, git merges the lines, as it would without either.
"""

from __future__ import annotations

import os
from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME
from tracerisk.adder.sources.write import FileWrite, write_all
from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import InputError, readable
from tracerisk.pipeline.history.git import git
from tracerisk.pipeline.history.repository import Repository

DRIVER = "tracerisk-lock"
_FILE = ".gitattributes"
_ATTRIBUTE = f"{LOCK_NAME} merge={DRIVER}"
# Without tracerisk, or for a lock that it cannot read, the lines are merged after all.
_COMMAND = "tracerisk lock-merge %O %A %B 2>/dev/null || git merge-file -q %A %O %B"


def install_merge_driver(folder: Path) -> tuple[str, ...]:
    """Set up the repository that the folder is in; return what was done.

    The driver goes into the repository's own configuration, the attribute into the
    `.gitattributes` at its top.
    Raises InputError where there is no repository, or one of them cannot be written.
    """
    with Repository.opened(folder) as repository:
        top = repository.top
        for key, value in (("name", f"merge of {LOCK_NAME}"), ("driver", _COMMAND)):
            repository.output("config", "--local", f"merge.{DRIVER}.{key}", value)
    driver = f"git merges {LOCK_NAME} with tracerisk in this clone"
    attributes = _attributes(top)
    if attributes is None:
        return (driver,)
    write_all([attributes])
    return (driver, f"{_FILE}: `{_ATTRIBUTE}`; commit it, so that each clone can do so")


def merge_driver_changes(folder: Path) -> dict[str, str]:
    """Return what `install_merge_driver` would write, by path from the folder, with its purpose.

    Raises InputError where there is no repository, or its attributes cannot be read.
    """
    with Repository.opened(folder) as repository:
        top = repository.top
        set_up = git(top, "config", "--local", "--get", f"merge.{DRIVER}.driver").stdout.decode()
    at_top = Path(os.path.relpath(top.resolve(), folder.resolve()))
    changes = {}
    if _attributes(top) is not None:
        changes[(at_top / _FILE).as_posix()] = f"by which git merges {LOCK_NAME} by controllers"
    if set_up.strip() != _COMMAND:
        path = (at_top / ".git/config").as_posix()
        changes[path] = f"by which git merges {LOCK_NAME} in this clone, with tracerisk"
    return changes


def hook_path(folder: Path) -> str:
    """Return where git looks for the hook of a commit, by path from the folder.

    Outside of a repository it is where it will be after `git init` there.
    """
    try:
        with Repository.opened(folder) as repository:
            told = repository.output("rev-parse", "--git-common-dir")
            hook = repository.top / os.fsdecode(told).rstrip("\n") / "hooks/pre-commit"
    except InputError:
        hook = folder / ".git/hooks/pre-commit"
    return os.path.relpath(hook.resolve(), folder.resolve())


def _attributes(top: Path) -> FileWrite | None:
    """Return how the attributes of a repository are to be written; `None` where they are right."""
    path = top / _FILE
    with readable(path):
        before = file_bytes(path) if path.exists() else b""
    if _ATTRIBUTE.encode() in (line.strip() for line in before.splitlines()):
        return None
    end = b"" if not before or before.endswith(b"\n") else b"\n"
    after = before + end + _ATTRIBUTE.encode() + b"\n"
    return FileWrite(path, after, expected=before if path.exists() else None)
