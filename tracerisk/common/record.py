"""What a figure was made from: versions, digests and the commit.

The same inputs at the same commit give the same record: it holds no time of day and no machine.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

FileRole = Literal["source", "lock", "settings", "hardware", "scenario", "evidence", "other input"]
FileState = Literal["as committed", "changed since", "not committed", "with tracerisk", ""]
"""How a file stands to the commit; "" where no commit is known."""
RobotKind = Literal["own description", "shipped with tracerisk", "assumed"]


@dataclass(frozen=True, slots=True)
class Commit:
    """The commit of git that the files are checked out from."""

    id: str
    """Hash of the commit."""
    committed: str
    """Committer's date, ISO 8601 with the committer's offset from UTC."""
    changed: tuple[str, ...] = ()
    """Tracked files of the working tree that differ from the commit, from its top, sorted."""


@dataclass(frozen=True, slots=True)
class RecordedFile:
    """A file that the figure was made from."""

    role: FileRole
    """What the file is for."""
    path: str
    """Path from the controller's root; of a shipped file, from that of tracerisk."""
    sha256: str
    """SHA-256 digest of its bytes."""
    state: FileState = ""
    """How it stands to the commit."""


@dataclass(frozen=True, slots=True)
class RobotOrigin:
    """The robot of the run, and where its description comes from."""

    name: str
    """Name of the robot."""
    kind: RobotKind
    """Whose description it is."""
    reasons: tuple[str, ...] = ()
    """Why it is this one and what of it is assumed, one sentence each."""


@dataclass(frozen=True, slots=True)
class Record:
    """What a figure was made from."""

    version: str
    """Version of tracerisk."""
    commit: Commit | None
    """The commit of git; `None` where there is none."""
    no_commit: str = ""
    """Why there is no commit; "" where there is one."""
    files: tuple[RecordedFile, ...] = ()
    """The files, sorted by role and path."""
    robot: RobotOrigin | None = None
    """The robot; `None` where no run is known."""
    fingerprint: str = ""
    """Digest of all that the run depended on, as the lock has it; "" where no run is known."""
    outcome: Mapping[str, Any] = field(default_factory=dict)
    """What the run brought about, as the lock keeps it; empty where that is not known."""
    variables: Mapping[str, str] = field(default_factory=dict)
    """The digest of each environment variable that the settings name, by its name."""


def record_data(record: Record) -> dict[str, Any]:
    """Return the record as JSON has it."""
    data = asdict(record)
    data["tracerisk"] = data.pop("version")
    if not record.variables:
        del data["variables"]
    return data
