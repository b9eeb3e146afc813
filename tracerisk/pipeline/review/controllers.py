"""Which controllers the annotated files belong to, by the lock of each version."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock, Lock
from tracerisk.adder.lock.reading import loads
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.outcome.kept import OUTCOME, kept_changes, kept_outcome
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.pipeline.freshness.known_controllers import has_digest
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.review.annotated_files import AnnotatedFiles, is_annotated, is_within
from tracerisk.pipeline.review.changed_inputs import changed_inputs
from tracerisk.pipeline.review.git_versions import Compared, GitVersion, in_version
from tracerisk.pipeline.review.version_inputs import (
    RunOfVersion,
    ScenarioOfVersion,
    depends_on,
    description_of,
    inputs_now,
    is_of_refused_run,
    modules_of,
    recorded_sources,
    scenario_of,
    success_of,
    success_place,
)
from tracerisk.pipeline.trace.kept_verdict import kept_verdict

if TYPE_CHECKING:
    from tracerisk.common.evidence.cells import Evidence
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.ros.scenario.success import Condition

NOT_RUN = f"{LOCK_NAME} knows no run of it"
"""Why the blocks of a controller that no lock knows are stale."""


class ControllerVersion(NamedTuple):
    """A controller in one version."""

    sources: Mapping[str, bytes]
    """The annotated sources, by path from the top."""
    entry: ControllerLock | None
    """The entry of the controller in the lock; `None` where no lock knows it."""
    folder: str
    """The folder of the lock, from which the entry names files."""
    evidence: Evidence | None = None
    """What failures of its hardware did on the twin; `None` where none is kept."""
    stale: tuple[str, ...] = ()
    """What has changed since the run behind the blocks, or that there was none, in words."""
    hardware: Hardware | None = None
    """The hardware description; `None` unless the two versions differ in it."""
    success: tuple[Condition, ...] | None = ()
    """What `success` of its scenario declares; empty unless the two versions differ in the
    scenario or the outcome, `None` where that cannot be read."""
    success_place: Location | None = None
    """Where that stands, from the top; `None` where it is not looked up or has no file."""
    inputs: RunInputs | None = None
    """What its run depended on, as the version has it; `None` where no lock knows a run."""
    is_refused: bool = False
    """Whether a run of it as it is went wrong, and its blocks were not written."""
    modules: Mapping[str, bytes] = {}
    """All sources of its run, by path from the top; empty where no lock knows a run."""


class ReviewedController(NamedTuple):
    """A controller in both versions."""

    name: str
    """The path from the top in the later version."""
    was: str | None
    """The earlier path where it moved; `None` where it did not."""
    before: ControllerVersion
    """The earlier version."""
    after: ControllerVersion
    """The later version."""
    is_changed: bool = True
    """Whether the change has to do with it; `False` where only its figure as it is counts."""


class _Known(NamedTuple):
    """What a lock knows of a controller."""

    entry: ControllerLock
    """The entry of the controller in the lock."""
    folder: str
    """The folder of the lock, from the top."""
    files: tuple[str, ...]
    """The files with blocks, by path from the top, the controller first."""


def _as_it_is(path: str) -> str:
    return path


@dataclass
class Locks:
    """The locks of one version, each read once."""

    version: GitVersion
    """The version of the repository."""
    shown: Callable[[str], str] = _as_it_is
    """Returns how messages name a path."""
    changed: frozenset[str] = frozenset()
    """The paths of the files that differ from the version that this one is compared with."""
    _read: dict[str, dict[str, _Known]] = field(default_factory=dict)
    """The controllers of each lock read so far, by folder and path."""
    _evidence: dict[str, dict[str, Evidence]] = field(default_factory=dict)
    """The evidence read so far, by folder and controller."""
    _scenarios: dict[str, ScenarioOfVersion | None] = field(default_factory=dict)
    """The scenarios read so far, by the path of the controller."""

    def controllers_of(self, path: str) -> list[str]:
        """Return the controllers that a file belongs to, by the nearest lock that knows it."""
        for folder in PurePosixPath(path).parents:
            names = [name for name, known in self._in(str(folder)).items() if path in known.files]
            if names:
                return names
        return []

    def known(self, controller: str) -> _Known | None:
        """Return what the nearest lock knows of a controller."""
        for folder in PurePosixPath(controller).parents:
            if controller in (known := self._in(str(folder))):
                return known[controller]
        return None

    def run_of(self, controller: str) -> RunOfVersion | None:
        """Return what the nearest lock knows of the run of a controller."""
        known = self.known(controller)
        if known is None:
            return None
        return RunOfVersion(self.version, controller, known.entry, known.folder)

    def scenario_of(self, controller: str) -> ScenarioOfVersion | None:
        """Return the scenario of the run of a controller; `None` where no lock knows a run."""
        if controller not in self._scenarios:
            run = self.run_of(controller)
            scenario = None if run is None else scenario_of(run, self.changed)
            self._scenarios[controller] = scenario
        return self._scenarios[controller]

    def is_beside_lock(self, path: str) -> bool:
        """Return whether a lock lies in a folder above a file."""
        return any(
            self.version.file(_below(str(folder), LOCK_NAME)) is not None
            for folder in PurePosixPath(path).parents
        )

    def evidence_of(self, controller: str, folder: str) -> Evidence | None:
        """Return what is kept beside the lock of a folder of a controller below it."""
        if folder not in self._evidence:
            path = _below(folder, EVIDENCE_NAME)
            content = self.version.file(path)
            if content is None:
                self._evidence[folder] = {}
                return None
            from tracerisk.common.evidence.file import loads_evidence  # few keep evidence

            try:
                self._evidence[folder] = loads_evidence(content.decode(), self.shown(path))
            except (TraceRiskError, UnicodeDecodeError) as error:
                problem = error if isinstance(error, TraceRiskError) else InputError("is not UTF-8")
                raise in_version(problem, self.version) from error
        name = os.path.relpath(controller, folder)
        return self._evidence[folder].get(PurePosixPath(name).as_posix())

    def _in(self, folder: str) -> dict[str, _Known]:
        if folder not in self._read:
            self._read[folder] = dict(self._load(folder))
        return self._read[folder]

    def _load(self, folder: str) -> Iterator[tuple[str, _Known]]:
        path = _below(folder, LOCK_NAME)
        content = self.version.file(path)
        if content is None:
            return
        try:
            lock: Lock = loads(content, self.shown(path))
        except TraceRiskError as error:
            raise in_version(error, self.version) from error
        for name, entry in lock.controllers.items():
            listed = dict.fromkeys([name, *(file for file, held in entry.blocks.items() if held)])
            files = tuple(_below(folder, file) for file in listed)
            yield _below(folder, name), _Known(entry, folder, files)


def reviewed_controllers(
    files: AnnotatedFiles,
    what: Compared,
    shown: Callable[[str], str],
    *,
    with_others: bool = False,
) -> list[ReviewedController]:
    """Return the controllers that the files belong to, with all of their annotated sources.

    A file that no lock knows is a controller of its own. `shown` returns how messages name a path.
    If asked, all others of the later version's locks come last.
    Raises InputError, naming the version, where a lock cannot be read.
    """
    locks = Locks(what.before, shown), Locks(what.after, shown, files.changed)
    was = {new: old for old, new in files.renames.items()}
    names: dict[str, None] = {}
    for old, new in files.pairs:
        controllers = [] if new is None else locks[1].controllers_of(new)
        if old is not None:
            controllers += [files.renames.get(name, name) for name in locks[0].controllers_of(old)]
        own = new if new is not None else old
        names.update(dict.fromkeys(controllers or [str(own)]))
    for folder in files.lock_folders:
        names.update(dict.fromkeys(_of_other_run(locks, folder, what.paths)))
    # The entry of a controller that moved may stay in the lock: the controller is not lost.
    there = [name for folder in files.locks for name in sorted(locks[1]._in(folder))]
    there = [name for name in there if name not in files.renames]
    names.update(dict.fromkeys(_made_stale(locks[1], there, files.changed - names.keys(), what)))
    others = sorted({name for name in there if is_within(name, what.paths)} - names.keys())
    return [
        *(_reviewed(name, was.get(name), locks, files.renames) for name in sorted(names)),
        *(
            _reviewed(name, None, locks, {})._replace(is_changed=False)
            for name in others
            if with_others
        ),
    ]


def _of_other_run(
    locks: tuple[Locks, Locks], folder: str, paths: tuple[str, ...] | None
) -> Iterator[str]:
    """Yield the controllers of a lock whose run has other sources, results, verdict or scenario.

    Among them are those whose run accepts something else, or whose verdict or outcome is lost.
    """
    earlier, later = locks[0]._in(folder), locks[1]._in(folder)
    for name in sorted(earlier.keys() & later.keys()):
        if is_within(name, paths) and (
            _is_other_run(earlier[name].entry, later[name].entry)
            or _has_other_scenario(locks, name)
            or recorded_sources(earlier[name].entry) != recorded_sources(later[name].entry)
        ):
            yield name


def _is_other_run(before: ControllerLock, after: ControllerLock) -> bool:
    old, new = kept_verdict(before), kept_verdict(after)
    if old is not None and (
        new is None or old.kind != new.kind or old.acceptances != new.acceptances
    ):
        return True
    if before.trace.get(OUTCOME) == after.trace.get(OUTCOME):
        return False
    changes = kept_changes(before.trace, after.trace)
    if changes is None:
        return kept_outcome(before.trace) is not None
    return bool(changes.of_mission)


def _has_other_scenario(locks: tuple[Locks, Locks], name: str) -> bool:
    before, after = (one.scenario_of(name) for one in locks)
    return before is not None and after is not None and before != after


def _made_stale(
    locks: Locks, names: list[str], changed: frozenset[str], what: Compared
) -> Iterator[str]:
    """Yield the controllers whose blocks a changed file made stale.

    The review looks at the controller or at the file.
    """
    looked_at = frozenset(path for path in changed if is_within(path, what.paths))
    for name in names:
        files = changed if is_within(name, what.paths) else looked_at
        run = locks.run_of(name)
        if run is not None and depends_on(run, files) and version_of(locks, name).stale:
            yield name


def _reviewed(
    name: str, was: str | None, locks: tuple[Locks, Locks], renames: Mapping[str, str]
) -> ReviewedController:
    backwards = {new: old for old, new in renames.items()}
    earlier = was or name
    known = locks[0].known(earlier), locks[1].known(name)
    guesses = (
        [backwards.get(file, file) for file in known[1].files] if known[1] else [earlier],
        [renames.get(file, file) for file in known[0].files] if known[0] else [name],
    )
    names = earlier, name
    before = _version(locks[0], known[0], guesses[0], names)
    after = _version(locks[1], known[1], guesses[1], names[::-1])
    before, after = (
        version._replace(modules=modules_of(one.run_of(path), version.inputs))
        for one, path, version in zip(locks, names, (before, after), strict=True)
    )
    if after.stale or _hardware(before) != _hardware(after):
        before, after = (
            version._replace(hardware=_description(one, path, version))
            for one, path, version in zip(locks, names, (before, after), strict=True)
        )
    if known[0] and known[1]:
        before, after = _with_success(locks, names, (before, after))
    return ReviewedController(name, was, before, after)


def _with_success(
    locks: tuple[Locks, Locks],
    names: tuple[str, str],
    versions: tuple[ControllerVersion, ControllerVersion],
) -> tuple[ControllerVersion, ControllerVersion]:
    """Return the versions with their `success`, if their scenarios or outcomes differ."""
    before, after = (one.run_of(path) for one, path in zip(locks, names, strict=True))
    old, new = (one.scenario_of(path) for one, path in zip(locks, names, strict=True))
    if before is None or after is None or old is None or new is None:
        return versions
    if old == new and before.entry.trace.get(OUTCOME) == after.entry.trace.get(OUTCOME):
        return versions
    if old == new:
        success = success_of(after, new) or ()
        return versions[0]._replace(success=success), versions[1]._replace(success=success)
    return (
        versions[0]._replace(success=success_of(before, old)),
        versions[1]._replace(
            success=success_of(after, new), success_place=success_place(after, new)
        ),
    )


def _hardware(version: ControllerVersion) -> tuple[str, object]:
    """Return what identifies the hardware description behind the blocks of a version."""
    inputs = RunInputs() if version.entry is None else RunInputs.from_data(version.entry.inputs)
    return inputs.hardware, inputs.settings.get("hardware")


def _description(locks: Locks, controller: str, version: ControllerVersion) -> Hardware | None:
    run = locks.run_of(controller)
    return None if run is None or version.inputs is None else description_of(run, version.inputs)


def version_of(locks: Locks, controller: str) -> ControllerVersion:
    """Return a controller as the version of the locks has it, by its path from the top.

    Raises InputError, naming the version, where a lock cannot be read.
    """
    return _version(locks, locks.known(controller), [], (controller, controller))


def _version(
    locks: Locks, known: _Known | None, guesses: list[str], names: tuple[str, str]
) -> ControllerVersion:
    """Return a controller as one version has it; `names` are its own there and in the other.

    Where that version's lock does not know it, it is taken to have the files it has in the other,
    those left out that this version's lock gives to another controller.
    """
    controller = names[0]
    files: list[str] = []
    if known is not None:
        files = list(known.files)
    else:
        for file in dict.fromkeys([controller, *guesses]):
            if set(locks.controllers_of(file)) <= set(names):
                files.append(file)
    contents = {file: locks.version.file(file) for file in sorted(files)}
    sources = {
        file: content
        for file, content in contents.items()
        if content is not None and is_annotated(file, content)
    }
    run = locks.run_of(controller)
    if known is None or run is None:
        is_left_out = any(map(has_digest, sources.values())) or locks.is_beside_lock(controller)
        not_run = (NOT_RUN,) if sources and is_left_out else ()
        return ControllerVersion(sources, None, ".", stale=not_run)
    evidence = locks.evidence_of(controller, known.folder)
    try:
        now = inputs_now(run, sources, locks.changed)
    except TraceRiskError as error:
        raise in_version(error, locks.version) from error
    stale = tuple(changed_inputs(run.recorded, now, lambda file: _shown(run, file, locks)))
    is_refused = bool(stale) and is_of_refused_run(run, sources, locks.changed)
    return ControllerVersion(
        sources, known.entry, known.folder, evidence, stale, inputs=now, is_refused=is_refused
    )


def _shown(run: RunOfVersion, file: str, locks: Locks) -> str:
    path = run.path_of(file)
    return file if path is None else locks.shown(path)


def _below(folder: str, path: str) -> str:
    return path if folder == "." else f"{folder}/{path}"
