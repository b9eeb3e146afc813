"""Gather the record of a figure: the files behind it, their digests, the commit, the robot."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.hardware.model import Hardware
from tracerisk.common.hardware.shipped import bare_arm, shipped_bytes
from tracerisk.common.hardware.source_files import source_files
from tracerisk.common.outcome.kept import OUTCOME, outcome_summary
from tracerisk.common.outcome.tolerances import Tolerances
from tracerisk.common.record import (
    FileRole,
    FileState,
    Record,
    RecordedFile,
    RobotKind,
    RobotOrigin,
)
from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes
from tracerisk.common.text.digests import sha256
from tracerisk.common.version import __version__
from tracerisk.config import Settings, controller_root
from tracerisk.errors import readable
from tracerisk.pipeline.dossier.commit import checked_out
from tracerisk.pipeline.freshness.run_inputs import variable_digests
from tracerisk.pipeline.workspace.controller import from_root
from tracerisk.trace import Trace
from tracerisk.twin.robots.robot import robot_names

_ROLES: tuple[FileRole, ...] = (
    *("source", "lock", "settings", "hardware", "scenario", "evidence", "other input"),
)
_APPROXIMATE = "are approximate"
_DESCRIPTIONS = (".urdf", ".xacro", ".srdf", ".mjcf", ".sdf")


def make_record(
    sources: Mapping[str, bytes],
    settings: Settings,
    *,
    trace: Trace | None = None,
    hardware: Hardware | None = None,
    fingerprint: str = "",
    made: Collection[Path] = (),
) -> Record:
    """Return the record of a figure of annotated sources, which map their files to their bytes.

    `trace`, `hardware` and `fingerprint` are those of the run behind them, where it is known.
    Files that are `made` of the others, as a report is, do not count as changed in git.
    Raises InputError for a file that cannot be read.
    """
    root = controller_root(Path(next(iter(sources)))).resolve()
    texts = {Path(os.path.normpath(Path(file).absolute())): data for file, data in sources.items()}
    roles = _files(root, texts, settings, trace)
    contents = {path: texts[path] if path in texts else whole_file(path) for path in roles}
    found = checked_out(root, contents, made=made)
    states: Mapping[Path, FileState] = {} if isinstance(found, str) else found.states
    files = [
        RecordedFile(
            role,
            from_root(root, path),
            sha256(contents[path]),
            states.get(path, ""),
        )
        for path, role in roles.items()
    ]
    if hardware is not None and settings.hardware is None:
        digest = sha256(shipped_bytes(hardware))
        files.append(RecordedFile("hardware", hardware.file, digest, "with tracerisk"))
    files.sort(key=lambda file: (_ROLES.index(file.role), file.path))
    return Record(
        version=__version__,
        commit=None if isinstance(found, str) else found.commit,
        no_commit=found if isinstance(found, str) else "",
        files=tuple(files),
        robot=None if trace is None or not trace.robot else _robot(trace, settings),
        fingerprint=fingerprint,
        outcome={} if trace is None else _outcome(trace, settings),
        variables=variable_digests(settings),
    )


def whole_file(path: Path) -> bytes:
    """Return the bytes of a file; InputError with its place where it cannot be read."""
    with readable(path):
        return file_bytes(path, MOST_WRITTEN)


def _files(
    root: Path, texts: Collection[Path], settings: Settings, trace: Trace | None
) -> dict[Path, FileRole]:
    """Return the files that are there, and what each is for; the first role counts."""
    roles: dict[Path, FileRole] = dict.fromkeys(texts, "source")
    for name, role in _named(settings, trace):
        path = Path(os.path.normpath(root / name))
        if path.is_file():
            roles.setdefault(path, role)
    return roles


def _named(settings: Settings, trace: Trace | None) -> Iterator[tuple[str | Path, FileRole]]:
    """Yield files with their roles: of the root by their names, others by their paths."""
    yield LOCK_NAME, "lock"
    yield "pyproject.toml", "settings"
    if settings.evidence:
        yield EVIDENCE_NAME, "evidence"
    if settings.hardware is not None:
        for file in source_files(Path(settings.hardware)):
            yield file.absolute(), "hardware"
    if settings.scenario is not None:
        yield Path(settings.scenario).absolute(), "scenario"
    others = (settings.scene, settings.robot, *settings.params, *settings.drivers)
    for named in others:
        if named is not None:
            yield Path(named).absolute(), "other input"
    if trace is not None:
        yield from ((file, "source") for file in (trace.controller, *trace.files))
        yield from ((file, "other input") for file in trace.inputs)


def _robot(trace: Trace, settings: Settings) -> RobotOrigin:
    """Return whose description of the robot the run took, by what it says of it."""
    prefix = "robot: "
    reasons = tuple(
        line.removeprefix(prefix) for line in trace.assumptions if line.startswith(prefix)
    )
    is_named = settings.robot is not None and Path(settings.robot).suffix != ""
    kind: RobotKind = "assumed"
    if any(_APPROXIMATE in reason for reason in reasons):
        kind = "assumed"
    elif is_named or any(name.endswith(_DESCRIPTIONS) for name in trace.inputs):
        kind = "own description"
    elif bare_arm(trace.robot) in robot_names():
        kind = "shipped with tracerisk"
    return RobotOrigin(trace.robot, kind, reasons)


def _outcome(trace: Trace, settings: Settings) -> Mapping[str, object]:
    kept = outcome_summary(trace.outcome, Tolerances.of(settings)).get(OUTCOME, {})
    return dict(kept)
