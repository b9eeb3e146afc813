"""What a trace and its values depended on, with digests by which it is compared.

The lock keeps, for each controller, the settings of its run and a digest of each file it depended
on: of its sources without comments and blank lines, of other files byte for byte.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.common.settings.python_here import CHANGED_PYTHON, changed_python
from tracerisk.common.settings.settings_file import names_file
from tracerisk.common.text.bounded import MOST_OF_A_RUN, file_bytes
from tracerisk.common.text.digests import sha256
from tracerisk.common.version import __version__
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.freshness.used_evidence import evidence_digest
from tracerisk.pipeline.workspace.controller import Controller, from_root

if TYPE_CHECKING:
    from tracerisk.trace import Trace

GONE = "gone"
"""What stands for the digest of a file that was looked for and is not there."""
UNSET = "unset"
"""What stands for the digest of an environment variable that is not set."""
_LOOKED_AT = 8000  # bytes of which git too takes a NUL as a sign that a file is no text

# Settings that change neither a run nor its values: how long it may take, what is demanded of it.
_LIMITS = frozenset(
    {
        *("cpu_limit_s", "wall_limit_s", "stall_limit_s", "memory_limit_mb"),
        *(
            "max_failure_probability",
            "max_undetected_probability",
            "require_reason",
            "fail_on",
            "min_coverage",
            "sandbox",
        ),
        "require_worlds",
        # How values are written, not what they are.
        *("blocks", "tolerance"),
        *("outcome_place_mm", "outcome_angle_deg", "outcome_joint_mrad"),
        # What evidence the values took has a digest of its own.
        *("evidence", "evidence_cells"),
    }
)
_LEFT_OUT_EMPTY = ("libraries", "evidence", "prefixes", "variables")
_MEASURED = "measured"
_OF_VALUES = frozenset({"hardware", "system", "active"})


@dataclass(frozen=True, slots=True)
class RunInputs:
    """What a trace and the values made of it depended on, in plain JSON values."""

    settings: Mapping[str, Any] = field(default_factory=dict)
    """The settings that differ from their defaults, and the version of tracerisk."""
    given: Mapping[str, Any] = field(default_factory=dict)
    """The settings that came from the command line."""
    sources: Mapping[str, str] = field(default_factory=dict)
    """The digest of each source without comments and blank lines, by path from the root."""
    files: Mapping[str, str] = field(default_factory=dict)
    """The digest of each other file, by path from the root."""
    hardware: str = ""
    """The digest of the hardware description; it changes values, not the trace, and is no part of
    the fingerprint."""
    libraries: tuple[str, ...] = ()
    """The sources that are library code, whose functions are no steps; sorted."""
    evidence: str = ""
    """A digest of the evidence that the values took; empty for none."""
    prefixes: tuple[str, ...] = ()
    """The folders of an installed ROS and of overlays in which some of the files are, sorted."""
    variables: Mapping[str, str] = field(default_factory=dict)
    """The digest of each environment variable that the settings name, by its name."""

    @property
    def fingerprint(self) -> str:
        """A digest of all that a run depends on."""
        run = {name: value for name, value in self.settings.items() if name not in _OF_VALUES}
        parts: list[Any] = [run, dict(self.sources), dict(self.files)]
        if self.libraries:
            parts.append(list(self.libraries))
        if self.variables:
            parts.append(dict(self.variables))
        return sha256(json.dumps(parts, sort_keys=True).encode())

    def data(self) -> dict[str, Any]:
        """Return what the lock keeps."""
        lists = {"libraries": list(self.libraries), "prefixes": list(self.prefixes)}
        data = {**asdict(self), **lists}
        return {key: data[key] for key in data if data[key] or key not in _LEFT_OUT_EMPTY}

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> RunInputs:
        """Return the inputs that a lock keeps; what it lacks is empty, and so never fresh."""

        def table(name: str) -> Mapping[str, Any]:
            value = data.get(name)
            return value if isinstance(value, dict) else {}

        return cls(
            table("settings"),
            table("given"),
            table("sources"),
            table("files"),
            str(data.get("hardware", "")),
            tuple(map(str, data.get("libraries", ()))),
            str(data.get("evidence", "")),
            tuple(map(str, data.get("prefixes", ()))),
            table("variables"),
        )


def run_inputs(
    controller: Controller,
    trace: Trace,
    settings: Settings,
    *,
    given: Mapping[str, Any] | None = None,
) -> RunInputs:
    """Return what a trace depended on, as it stands now.

    `given` are those of the settings that came from the command line.
    Raises InputError for a file that cannot be read.
    """
    root = controller.root.resolve()
    listed = {*trace.inputs, *files_named(controller, settings)}
    sources = {controller.file, *trace.files}
    if not controller.is_python:  # its other sources and headers: their comments change no run
        sources |= {file for file in trace.inputs if is_c(file)}
    inputs = RunInputs(
        settings=settings_data(settings, root),
        given=_given_data(given, root),
        sources={file: code_digest(controller.source_of(file), file) for file in sorted(sources)},
        files={file: file_digest(root / file) for file in sorted(listed - sources)},
        hardware=hardware_digest(settings),
        libraries=libraries_of(controller, settings, sources),
        prefixes=_prefixes_of(listed, controller, settings),
        variables=variable_digests(settings),
    )
    if trace.is_measured and (controller.is_python or not trace.is_live):
        # No run of the twin gives this trace again: blocks that are made of it are never fresh.
        # A compiled controller has no other run on the twin than a live one.
        inputs = replace(inputs, settings={**inputs.settings, _MEASURED: True})
    used = evidence_digest(controller, settings, inputs.fingerprint)
    return replace(inputs, evidence=used)


def files_named(controller: Controller, settings: Settings) -> set[str]:
    """Return the files that settings, robot and drivers name for a run, from the root."""
    # Not needed to check whether a trace is fresh, which must be quick.
    from tracerisk.pipeline.robot.choice import robot_files
    from tracerisk.pipeline.workspace.driver_files import driver_files

    root = controller.root.resolve()
    scene = settings.scene if settings.scene is not None and Path(settings.scene).suffix else None
    robot = map(str, robot_files(controller, settings))
    drivers = map(str, driver_files(controller.project, settings))
    named = (settings.scenario, scene, *settings.params, *drivers, *robot)
    return {from_root(root, Path(file).resolve()) for file in named if file is not None}


def settings_data(settings: Settings, root: Path) -> dict[str, Any]:
    """Return the settings that a run or its values depend on and that are not the default."""
    default = Settings()
    data: dict[str, Any] = {"tracerisk": __version__}
    for entry in fields(Settings):
        value = getattr(settings, entry.name)
        if entry.name not in _LIMITS and value != getattr(default, entry.name):
            data[entry.name] = _plain(entry.name, value, root)
    if changed := changed_python():
        data[CHANGED_PYTHON] = changed
    return data


def hardware_digest(settings: Settings) -> str:
    """Return a digest of the hardware description of the settings; empty for a shipped one.

    It covers the files beside it from which it is read.
    """
    if settings.hardware is None:
        return ""
    from tracerisk.common.hardware.source_files import source_files

    named = Path(settings.hardware)
    path, *beside = source_files(named)
    own = file_digest(path)
    if not beside:
        return own
    folder = path.parent if named.is_file() else named
    others = (f"{item.relative_to(folder).as_posix()} {file_digest(item)}" for item in beside)
    return sha256("\n".join((own, *others)).encode())


def variable_digests(settings: Settings) -> dict[str, str]:
    """Return a digest of each environment variable that the settings name, or that it is unset.

    No value stands anywhere: it may be a secret.
    """
    values = ((name, os.environ.get(name)) for name in sorted(settings.env))
    return {
        name: UNSET if value is None else sha256(f"{name}={value}".encode(errors="surrogateescape"))
        for name, value in values
    }


def content_digest(data: bytes) -> str:
    """Return a digest of what a file holds.

    A text has the same one with line ends of any kind: git may write those of the system.
    """
    is_text = b"\0" not in data[:_LOOKED_AT]
    return sha256(data.replace(b"\r\n", b"\n") if is_text else data)


def file_digest(path: Path) -> str:
    """Return the digest of a file's content, or that it is gone: then a run finds another."""
    try:
        return content_digest(file_bytes(path, MOST_OF_A_RUN))
    except FileNotFoundError:
        return GONE
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", Location(str(path))) from error


def _prefixes_of(
    files: Iterable[str], controller: Controller, settings: Settings
) -> tuple[str, ...]:
    """Return the prefixes in which files are that a run depended on, from the root."""
    from tracerisk.pipeline.workspace.workspace import prefixes_of

    root = controller.root.resolve()
    paths = [Path(os.path.normpath(root / file)) for file in files]
    result = prefixes_of(controller, settings)
    prefixes = (Path(prefix.path).resolve() for prefix in result)
    return tuple(
        sorted(
            from_root(root, prefix)
            for prefix in prefixes
            if any(path.is_relative_to(prefix) for path in paths)
        )
    )


def libraries_of(
    controller: Controller, settings: Settings, sources: Iterable[str]
) -> tuple[str, ...]:
    """Return which of the sources of a run are library code now; one that is gone is none."""
    if all(file == controller.file for file in sources):
        return ()
    from tracerisk.pipeline.workspace.libraries import Libraries

    libraries = Libraries(controller.path, controller.project, settings.states)
    paths = ((file, controller.path_of(file)) for file in sorted(sources))
    return tuple(file for file, path in paths if path.is_file() and libraries.holds(path))


def stated(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the options that were given, sorted by their names."""
    return {k: v for k, v in sorted((options or {}).items()) if v not in (None, (), [])}


def _given_data(given: Mapping[str, Any] | None, root: Path) -> dict[str, Any]:
    return {
        name: _plain(name, value, root)
        for name, value in stated(given).items()
        if name not in _LIMITS
    }


def _plain(name: str, value: Any, root: Path) -> Any:
    """Return a setting as JSON; a file that it names is given from the root."""
    if name in ("params", "drivers", "ros_prefixes"):
        return [from_root(root, Path(file).resolve()) for file in value]
    if names_file(name, value, Path()):
        return from_root(root, Path(value).resolve())
    if name == "accept":
        return [asdict(item) for item in value]
    return list(value) if isinstance(value, tuple) else value
