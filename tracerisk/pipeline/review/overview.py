"""All controllers of a repository at a glance, from their locks and blocks: nothing is run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock
from tracerisk.common.text.bounded import file_bytes
from tracerisk.common.verdict import Verdict
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.pipeline.freshness.known_controllers import locks_in
from tracerisk.pipeline.freshness.source_verdict import source_verdicts
from tracerisk.pipeline.model import build
from tracerisk.pipeline.workspace.project import Projects
from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.solve import solve


@dataclass(frozen=True, slots=True)
class KnownController:
    """A controller of a lock, by what its files say now."""

    name: str
    """Its path from the folder that was asked about, with `/`."""
    path: Path
    """The path of the controller's file."""
    sources: Mapping[str, bytes] = field(default_factory=dict)
    """Each file with its blocks, by its path as messages call it."""
    verdict: Verdict | None = None
    """Of the run behind the blocks; `None` where it is unknown."""
    model: HybridModel | None = None
    """The model of the blocks; `None` where there is no figure."""
    assessment: Assessment | None = None
    """`None` where it has no blocks, or none that can be read."""
    error: str = ""
    """Why there is no figure, in words."""

    @property
    def failure_probability(self) -> float | None:
        """Of a mission, by hardware."""
        assessment = self.assessment
        return None if assessment is None else assessment.mission.failure_probability


def overview(root: Path) -> tuple[KnownController, ...]:
    """Return every controller of every lock in and below a folder, sorted by name.

    What cannot be read of one controller is in its `error`, and keeps no other from being listed.
    Raises InputError where no lock below the folder knows a controller, or a lock is malformed.
    """
    projects = Projects()
    controllers = [
        known_controller(root, folder, name, entry, projects)
        for folder, lock in locks_in(root, projects)
        for name, entry in lock.controllers.items()
    ]
    if not controllers:
        raise InputError(
            f"no {LOCK_NAME} in or below it knows a controller; `tracerisk run FILE` writes one",
            Location(str(root)),
        )
    return tuple(sorted(controllers, key=lambda controller: controller.name))


def known_controller(
    root: Path, folder: Path, name: str, entry: ControllerLock, projects: Projects
) -> KnownController:
    """Return what the files of one controller say; `name` is its own in the lock of a folder."""
    path = folder / name
    shown = path.relative_to(root).as_posix()
    try:
        sources = _sources(root, folder, name, entry)
        model = build(sources, name=path.name)
        verdicts = source_verdicts(sources, projects)
        return KnownController(shown, path, sources, verdicts.get(name), model, solve(model))
    except TraceRiskError as error:
        return KnownController(shown, path, error=str(error))


def _sources(root: Path, folder: Path, name: str, entry: ControllerLock) -> dict[str, bytes]:
    """Return the controller's own file and the others of its blocks, as they are now."""
    others = sorted(file for file, blocks in entry.blocks.items() if blocks and file != name)
    sources = {}
    for file in (name, *others):
        path = folder / file
        if not path.resolve().is_relative_to(root.resolve()):
            raise InputError("is outside of the folder that was asked about", Location(str(path)))
        try:
            sources[str(path)] = file_bytes(path)
        except OSError as error:
            raise InputError(
                f"cannot be read: {error.strerror}; restore it, or `tracerisk refresh {path}` "
                "forgets it",
                Location(str(path)),
            ) from error
    return sources
