"""What the run behind a version's blocks depended on, as that version has it: nothing is run."""

from __future__ import annotations

import os
import posixpath
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.common.hardware.source_files import has_sysml_name
from tracerisk.common.settings.python_here import CHANGED_PYTHON
from tracerisk.common.settings.settings_file import loads_toml
from tracerisk.config import Settings
from tracerisk.errors import Location, SettingsError, TraceRiskError
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.instrument.source.language import is_c_like
from tracerisk.pipeline.check.check import given_options
from tracerisk.pipeline.freshness.run_inputs import (
    GONE,
    RunInputs,
    content_digest,
    hardware_digest,
    settings_data,
)
from tracerisk.pipeline.review.changed_inputs import changed_inputs
from tracerisk.pipeline.review.git_versions import GitVersion
from tracerisk.pipeline.trace.kept_verdict import refused_run
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.project import Project

if TYPE_CHECKING:
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.ros.scenario.success import Condition

PROJECT_FILE = "pyproject.toml"


class RunOfVersion(NamedTuple):
    """A run that a version's lock knows, and the version."""

    version: GitVersion
    """The version of the repository."""
    controller: str
    """The path of the controller from the top."""
    entry: ControllerLock
    """The entry of the controller in the lock."""
    folder: str
    """The folder of the lock, from the top."""

    @property
    def recorded(self) -> RunInputs:
        """What the run depended on."""
        return RunInputs.from_data(self.entry.inputs)

    def path_of(self, file: str) -> str | None:
        """Return the path of an input from the top; `None` for one outside the repository."""
        path = posixpath.normpath(posixpath.join(self.folder, file))
        return None if path.startswith(("../", "/")) else path

    @property
    def paths(self) -> Iterator[str]:
        """The paths of all that the run depended on, and of the settings."""
        recorded = self.recorded
        named = [PROJECT_FILE, *recorded.sources, *recorded.files]
        hardware = recorded.settings.get("hardware")
        if isinstance(hardware, str):
            named.append(hardware)
        yield from (path for path in map(self.path_of, named) if path is not None)


def depends_on(run: RunOfVersion, changed: Collection[str]) -> bool:
    """Return whether a run depended on a changed file, or on one beside its SysML description."""
    if any(path in changed for path in run.paths):
        return True
    hardware = run.path_of(str(run.recorded.settings.get("hardware", "")))
    return hardware is not None and any(
        path in changed for path in _beside(hardware, sorted(changed))
    )


def recorded_sources(entry: ControllerLock) -> Mapping[str, str]:
    """Return the digests of the sources of a run, by path from the folder of its lock."""
    return RunInputs.from_data(entry.inputs).sources


def modules_of(run: RunOfVersion | None, inputs: RunInputs | None) -> dict[str, bytes]:
    """Return the sources of a run as the version has them, by path from the top."""
    if run is None or inputs is None:
        return {}
    paths = (run.path_of(file) for file in sorted(inputs.sources))
    contents = {path: run.version.file(path) for path in paths if path is not None}
    return {path: content for path, content in contents.items() if content is not None}


def inputs_now(
    run: RunOfVersion, sources: Mapping[str, bytes], changed: Collection[str]
) -> RunInputs:
    """Return what the run depended on, as the version has it.

    `sources` are the version's annotated sources. Of other files only those that are in `changed`
    are looked at: what git does not track, or links to, is not in a commit.
    Raises TraceRiskError where a source or the settings cannot be read.
    """
    recorded = run.recorded
    now = replace(
        recorded,
        sources={
            file: _code(run, file, digest, sources, changed)
            for file, digest in recorded.sources.items()
        },
        files={file: _file(run, file, digest, changed) for file, digest in recorded.files.items()},
    )
    settings = _settings_now(run, changed)
    if settings is not None:
        now = replace(now, settings=settings)
    return replace(now, hardware=_hardware_now(run, now, changed))


def is_of_refused_run(
    run: RunOfVersion, sources: Mapping[str, bytes], changed: Collection[str]
) -> bool:
    """Return whether the run that the lock remembers as refused is of the version as it is."""
    refused = refused_run(run.entry)
    if refused is None:
        return False
    again = run._replace(entry=replace(run.entry, inputs=refused[1]))
    return not any(changed_inputs(again.recorded, inputs_now(again, sources, changed)))


def description_of(run: RunOfVersion, inputs: RunInputs) -> Hardware | None:
    """Return the hardware description that the settings of a version name, else the shipped one.

    `None` for one that the version does not have, or that cannot be read.
    """
    from tracerisk.common.hardware.formats import read_description
    from tracerisk.common.hardware.shipped import hardware_of

    name = inputs.settings.get("hardware")
    if name is None:
        shipped = hardware_of(str(run.entry.trace.get("robot", "")))
        # No file of the version has these places.
        unplaced = (replace(component, location=None) for component in shipped.components)
        return replace(shipped, components=tuple(unplaced))
    path = run.path_of(str(name))
    if path is None:
        return None
    try:
        with _as_files(run.version, _described_by(run.version, path)) as top:
            system = inputs.settings.get("system")
            return read_description(top / path, shown=path, system=system)
    except TraceRiskError:
        return None


class ScenarioOfVersion(NamedTuple):
    """The scenario of a version; two are equal where the versions have the same."""

    name: str
    """Its path from the lock's folder; empty for no scenario."""
    digest: str
    """Of what is in it; by the lock where git does not track it."""


def scenario_of(run: RunOfVersion, changed: Collection[str]) -> ScenarioOfVersion:
    """Return which scenario a version has, by its settings."""
    recorded = run.recorded
    settings = _settings_now(run, changed) or recorded.settings
    name = str(settings.get("scenario") or "")
    path = run.path_of(name) if name else None
    if path is None:
        return ScenarioOfVersion(name, recorded.files.get(name, ""))
    content = run.version.file(path)
    if content is not None:
        return ScenarioOfVersion(name, content_digest(content))
    return ScenarioOfVersion(name, GONE if path in changed else recorded.files.get(name, GONE))


def success_of(run: RunOfVersion, scenario: ScenarioOfVersion) -> tuple[Condition, ...] | None:
    """Return what a scenario declares under `success`; nothing without a scenario.

    `None` for one that the version does not have, or that cannot be read.
    """
    from tracerisk.ros.scenario.file.scenario_reader import read_scenario  # few changes touch it

    if not scenario.name:
        return ()
    path = run.path_of(scenario.name)
    if path is None:
        return None
    try:
        with _as_files(run.version, [path]) as top:
            return read_scenario(top / path).success
    except TraceRiskError:
        return None


def success_place(run: RunOfVersion, scenario: ScenarioOfVersion) -> Location | None:
    """Return where a scenario declares `success`, else its first line; `None` without its file."""
    path = run.path_of(scenario.name) if scenario.name else None
    content = None if path is None else run.version.file(path)
    if path is None or content is None:
        return None
    lines = content.splitlines()
    starts = (number for number, line in enumerate(lines, start=1) if line.startswith(b"success:"))
    return Location(path, next(starts, 1))


def _code(
    run: RunOfVersion,
    file: str,
    digest: str,
    sources: Mapping[str, bytes],
    changed: Collection[str],
) -> str:
    path = run.path_of(file)
    if path is None or is_c_like(file):
        return digest
    if path in sources:
        return code_digest(sources[path], path)
    if path not in changed:
        return digest
    content = run.version.file(path)
    return GONE if content is None else code_digest(content, path)


def _file(run: RunOfVersion, file: str, digest: str, changed: Collection[str]) -> str:
    path = run.path_of(file)
    if path is None or path not in changed:
        return digest
    content = run.version.file(path)
    return GONE if content is None else content_digest(content)


def _settings_now(run: RunOfVersion, changed: Collection[str]) -> dict[str, Any] | None:
    """Return the settings of a version as the lock keeps them; `None` where they cannot differ."""
    project = run.path_of(PROJECT_FILE)
    if project is None or (project not in changed and run.controller not in changed):
        return None
    script = run.version.file(run.controller)
    if script is None or (project not in changed and b"# /// script" not in script):
        return None
    recorded = run.recorded
    text = run.version.file(project)
    names = [run.controller, *([] if text is None else [project]), *_own_tables(run, text)]
    with _as_files(run.version, names) as top:
        root = top / run.folder
        controller = load_controller(top / run.controller, Project(root))
        try:
            settings: Settings = controller.settings
        except SettingsError as error:
            place = error.location
            if place is not None:
                file = os.path.relpath(place.file, top)
                place = replace(place, file=file)
            raise SettingsError(error.message, place) from error
        data = settings_data(settings.with_options(given_options(recorded, controller)), root)
    # Which tracerisk looks is no change of the settings, nor that a trace was measured.
    of_process = ("measured", "tracerisk", CHANGED_PYTHON)
    kept = {name: recorded.settings[name] for name in of_process if name in recorded.settings}
    stated = {name: value for name, value in data.items() if name not in of_process}
    return {**stated, **kept}


def _own_tables(run: RunOfVersion, text: bytes | None) -> Iterator[str]:
    """Yield the controllers that have a table of their own in the settings: they must be there."""
    try:
        table: Any = loads_toml((text or b"").decode())
        for key in ("tool", "tracerisk", "controllers"):
            table = table.get(key, {})
    except (ValueError, AttributeError):
        return  # whoever reads the settings says what is wrong
    for name in table:
        path = run.path_of(name)
        if path is not None and run.version.file(path) is not None:
            yield path


def _hardware_now(run: RunOfVersion, now: RunInputs, changed: Collection[str]) -> str:
    recorded = run.recorded
    name = now.settings.get("hardware")
    if name is None:
        return ""
    path = run.path_of(str(name))
    is_same = name == recorded.settings.get("hardware")
    if path is None or (is_same and path not in changed and not _beside(path, sorted(changed))):
        return recorded.hardware
    with _as_files(run.version, _described_by(run.version, path)) as top:
        return hardware_digest(Settings(hardware=str(top / path)))


def _described_by(version: GitVersion, path: str) -> list[str]:
    """Return the files that a description may be read from: itself, and of SysML those beside."""
    if has_sysml_name(path):
        names = version.names_in(posixpath.dirname(path))
    else:
        names = [] if path.lower().endswith((".yaml", ".yml")) else version.tracked()
    return list(dict.fromkeys([path, *_beside(path, names)]))


def _beside(path: str, names: Collection[str]) -> list[str]:
    """Return which of the paths are SysML files beside a SysML description, or below its folder."""
    if not has_sysml_name(path):
        below = f"{path}/"
        return [name for name in names if name.startswith(below) and has_sysml_name(name)]
    folder = PurePosixPath(path).parent
    return [name for name in names if has_sysml_name(name) and PurePosixPath(name).parent == folder]


@contextmanager
def _as_files(version: GitVersion, paths: Collection[str]) -> Iterator[Path]:
    """Yield a folder that holds those of the files that the version has, by their paths."""
    with TemporaryDirectory(prefix="tracerisk-") as name:
        top = Path(name).resolve()
        for path in paths:
            content = version.file(path)
            if content is not None:
                (top / path).parent.mkdir(parents=True, exist_ok=True)
                (top / path).write_bytes(content)
        yield top
