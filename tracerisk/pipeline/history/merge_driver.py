"""Merge `tracerisk.lock` for git controller by controller, and not line by line.

The attribute is committed with the repository; the driver is a matter of each clone. Where it is
not set up, or tracerisk is not at hand, git merges the lines, as it would without either.
"""

from __future__ import annotations

from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME
from tracerisk.adder.sources.write import FileWrite, write_all
from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import readable
from tracerisk.pipeline.history.repository import Repository

DRIVER = "tracerisk-lock"
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
    path = top / ".gitattributes"
    with readable(path):
        before = file_bytes(path) if path.exists() else b""
    driver = f"git merges {LOCK_NAME} with tracerisk in this clone"
    if _ATTRIBUTE.encode() in (line.strip() for line in before.splitlines()):
        return (driver,)
    end = b"" if not before or before.endswith(b"\n") else b"\n"
    after = before + end + _ATTRIBUTE.encode() + b"\n"
    write_all([FileWrite(path, after, expected=before if path.exists() else None)])
    return (driver, f"{path.name}: `{_ATTRIBUTE}`; commit it, so that each clone can do so")
