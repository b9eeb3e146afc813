"""The settings: `[tool.tracerisk]` of the `pyproject.toml` at a controller's root, and its own.

A controller may carry settings of its own in a block of inline script metadata (PEP 723).
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, NoReturn, get_args

from tracerisk.common.text.bounded import file_bytes, is_folder
from tracerisk.common.verdict import Acceptance
from tracerisk.errors import InputError, Location, SettingsError, one_of

if TYPE_CHECKING:
    from tracerisk.common.limits import Limits

ActiveMode = Literal["moving", "moving+holding"]
"""Which time counts as exposure: moving only, or moving, holding and grasping."""

FailOn = Literal["finding", "unexpected_contact", "planning_failure", "execution_failure"]
"""Which findings of a run make `run` exit 1: any that is no mere note, or those of a kind."""

RosDistro = Literal["noetic", "humble", "jazzy"]
"""The distributions of ROS whose rules are served."""

BlockForm = Literal["compact", "published"]
"""How a risk block is written: a line for the function and one a component, or one a value."""

SandboxMode = Literal["auto", "require", "off"]
"""Whether strangers' code is contained: where that works, always, or never."""

GREATEST_TOLERANCE = 0.05
"""The greatest `tolerance` that may be set."""

DEFAULT_DURATION_S = 300.0
"""The simulated time after which a run is over where nobody says otherwise [s]."""

SANDBOX_SETTINGS = ("sandbox", "readable", "writable", "env")
"""The settings that say how a run is contained."""

FRACTIONS = {
    "max_failure_probability": "probability",
    "max_undetected_probability": "probability",
    "min_coverage": "fraction",
}
"""The settings that are numbers from 0 to 1, and what each is called."""

FROM_ONE = ("mission_cycles", "evidence_cells")
"""The whole numbers that begin at 1; the others begin at 0."""

_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_TABLE = ("tool", "tracerisk")
_CONTROLLERS = "controllers"
_RELEASE = re.compile(r"\d+\.\d+\.\d+")
_ALIASES = {"max_risk": "max_failure_probability"}  # older names
_LISTS = {
    **dict.fromkeys(("args", "answers"), "strings"),
    **dict.fromkeys(("params", "drivers", "readable", "writable"), "file names"),
    "ros_prefixes": "folders",
    **dict.fromkeys(("states", "helpers"), "qualified names"),
    "env": "names of variables",
}
"""The settings that are lists, and of what."""
_NAMES_OF_FILES = ("robot", "scene", "scenario", "hardware", "launch")
PACKAGE_FILE = "package.xml"
"""The name of the manifest of a ROS package."""
_ROOT_MARKS = (PACKAGE_FILE, "pyproject.toml", "setup.py", ".git")
_BLOCK_BEGINS = "# /// script"
_BLOCK_ENDS = "# ///"


@dataclass(frozen=True, slots=True)
class Settings:
    """What a run and its model depend on beside the controller.

    The limits on time and memory end a run and decide nothing else.
    """

    robot: str | None = None
    """The name or file of the robot; `None`: inferred from the controller."""
    scene: str | None = None
    """The name or file of the scene; `None`: the robot's default."""
    scenario: str | None = None
    """The file with what the controller's world provides; `None`: none."""
    hardware: str | None = None
    """The name, file or folder of the hardware description; `None`: the robot's default."""
    system: str | None = None
    """The part of a description in SysML that is the system; `None`: the one with failure data."""
    ros_distro: RosDistro | None = None
    """The ROS distribution whose rules apply; `None`: found in the workspace or assumed."""
    moveit_release: str | None = None
    """The release of MoveIt 1 whose arguments calls have; `None`: that of the moveit_commander in
    the workspace or installed, or assumed by the arguments of the call."""
    ros_prefixes: tuple[str, ...] = ()
    """Folders of installed packages that precede those of the environment."""
    active: ActiveMode = "moving+holding"
    """The time that counts as exposure."""
    duration_s: float | None = None
    """The simulated time after which a run ends [s]; `None`: the default of 300."""
    cpu_limit_s: float = 120.0
    """The processor time after which a run is stopped [s]."""
    wall_limit_s: float = 1800.0
    """The wall time after which a run is stopped [s]."""
    stall_limit_s: float = 30.0
    """The time without simulated progress, while the controller computes or sleeps, after which a
    run is stopped; also the limit of a process that reads a file [s]."""
    memory_limit_mb: int = 8192
    """The address space of the controller's process [MB]."""
    seed: int = 0
    """The seed of everything random."""
    mission_cycles: int = 10
    """The number of cycles in a mission whose loop is endless."""
    params: tuple[str, ...] = ()
    """Files of ROS parameters."""
    drivers: tuple[str, ...] = ()
    """Files that describe drivers."""
    launch: str | bool = True
    """The launch file that starts the controller; `True`: search the workspace, `False`: none."""
    companions: bool = True
    """Whether workspace nodes that provide what it waits for are started with it."""
    draft: bool = True
    """Whether a value is drafted for what it requests in vain."""
    states: tuple[str, ...] = ()
    """Qualified names of functions that are always relevant."""
    helpers: tuple[str, ...] = ()
    """Qualified names of functions that are never relevant."""
    args: tuple[str, ...] = ()
    """The controller's command-line arguments."""
    answers: tuple[str, ...] = ()
    """The answers to its `input()` calls, in turn."""
    max_failure_probability: float | None = None
    """The greatest failure probability of a mission that `check` accepts; `None`: any."""
    max_undetected_probability: float | None = None
    """The greatest probability that `check` accepts of a mission that fails unnoticed, or does harm
    before it stops; `None`: any."""
    require_reason: bool = False
    """Whether `check` requires a reason for each value set by hand."""
    require_worlds: tuple[str, ...] = ()
    """Worlds in which `check` requires the last run to have been repeated without effect."""
    fail_on: FailOn | None = None
    """The findings that make `run` exit 1; `None`: none of them."""
    accept: tuple[Acceptance, ...] = ()
    """The reasons of a verdict that the user accepts."""
    min_coverage: float | None = None
    """The least share of hardware-commanding functions that must have run, 0 to 1; `None`: any."""
    blocks: BlockForm = "published"
    """The form in which new blocks are written; those that are there keep theirs."""
    tolerance: float = 0.005
    """The relative change of a computed probability up to which a refresh keeps the written one, if
    nothing behind it changed in kind; 0: every change is written."""
    sandbox: SandboxMode = "auto"
    """Whether workspace code runs contained: where supported, always, or never."""
    readable: tuple[str, ...] = ()
    """Additional files and folders that a contained run may read."""
    writable: tuple[str, ...] = ()
    """Folders that a contained run may write to permanently."""
    env: tuple[str, ...] = ()
    """Names of additional environment variables that a contained run receives."""
    evidence: bool = False
    """Whether blocks count only failures that ended the mission on the twin."""
    evidence_cells: int = 200
    """The number of failures that the campaign draws first."""
    outcome_place_mm: float = 2.0
    """The difference in place below which two outcomes are the same [mm]."""
    outcome_angle_deg: float = 2.0
    """The difference in tilt or turn below which two outcomes are the same [deg]."""
    outcome_joint_mrad: float = 5.0
    """The same for joints at rest [mrad, or mm]."""

    @property
    def run_duration_s(self) -> float:
        """The simulated time after which a run is over [s]: as given, else the default."""
        return DEFAULT_DURATION_S if self.duration_s is None else self.duration_s

    @property
    def limits(self) -> Limits:
        """What a process may take that reads a file for a run."""
        from tracerisk.common.limits import Limit, Limits, Sandbox

        return Limits(
            own=Limit("stall_limit_s", self.stall_limit_s),
            wall=Limit("wall_limit_s", self.wall_limit_s),
            memory=Limit("memory_limit_mb", self.memory_limit_mb),
            sandbox=Sandbox(self.sandbox, self.readable, self.writable, self.env),
        )

    @property
    def drawing_limits(self) -> Limits:
        """What the process may take that draws the pictures of a run."""
        limits = self.limits
        own = replace(limits.own, setting="cpu_limit_s", value=self.cpu_limit_s)
        return replace(limits, own=own)

    def with_options(self, options: Mapping[str, Any]) -> Settings:
        """Return the settings with those options of the command line that were given.

        A sandbox that is required there is not widened by a file of the workspace.
        """
        given = {name: value for name, value in options.items() if value is not None}
        if given.get("sandbox") == "require":
            given = {"readable": (), "writable": (), "env": (), "ros_prefixes": (), **given}
        return replace(self, **given)


def controller_root(path: Path) -> Path:
    """Return the folder that holds a controller's own source.

    The nearest folder upwards with `package.xml`, `pyproject.toml`, `setup.py` or `.git`; where
    there is none, the script's own folder.
    """
    folder = path.resolve().parent
    for parent in (folder, *folder.parents):
        if is_root(parent):
            return parent
    return folder


def repository_above(path: Path) -> Path | None:
    """Return the folder that holds the nearest `.git` above a file; `None` where there is none."""
    return next((one for one in path.resolve().parents if (one / ".git").exists()), None)


def is_root(folder: Path) -> bool:
    """Return whether a folder has a file that makes it the root of the controllers below it."""
    return any((folder / mark).exists() for mark in _ROOT_MARKS)


def from_here(root: Path) -> Callable[[str], str]:
    """Return what names a file of a controller's root as a user would type it from here."""

    def typed(file: str) -> str:
        if file.startswith("<"):
            return file  # no file: code that a program made
        path = str(root.resolve() / file)
        return min(os.path.relpath(path), os.path.normpath(path), key=len)

    return typed


class SettingOrigin(NamedTuple):
    """Where a setting comes from."""

    location: Location | None = None
    """The line that sets it; `None` for a default."""
    is_own: bool = False
    """Whether it is set for this controller alone, in its own table or in its file."""


class ProjectSettings:
    """The settings of the controllers below a root: of its `pyproject.toml`, and of each file.

    A controller's table `[tool.tracerisk.controllers."FILE"]` goes before the settings of all, and
    the settings in the file itself go before both. `robot`, `scene`, `scenario`, `hardware`,
    `params`, `drivers` and `launch` that name a file are its path from the root; those in the
    controller start from the controller's folder.
    """

    def __init__(self, root: Path) -> None:
        """Raises SettingsError where the `pyproject.toml` in `root` is not valid TOML."""
        path = root / "pyproject.toml"
        self._root = root
        self._of_all = [_Reader(path, _text(path), root)] if path.is_file() else []

    def of(self, file: str | None = None) -> Settings:
        """Return the settings of a controller, named from the root; without, those of all.

        Raises SettingsError with file and line at an unknown key or a bad value.
        """
        values: dict[str, Any] = {}
        last = None
        for last in self._readers(file):
            values.update(last.values(file))
        settings = Settings(**values)
        both = sorted(set(settings.states) & set(settings.helpers))
        if both and last is not None:
            last.fail("helpers", f"{', '.join(both)} stands in `states` too; keep it in one")
        return settings

    def origins(self, file: str | None = None) -> dict[str, SettingOrigin]:
        """Return where each setting of a controller comes from. Raises as `of`."""
        self.of(file)
        fromkeys = dict.fromkeys((field.name for field in fields(Settings)), SettingOrigin())
        for reader in self._readers(file):
            fromkeys.update(reader.origins(file))
        return fromkeys

    @property
    def controllers(self) -> tuple[str, ...]:
        """The controllers that have a table of their own in the `pyproject.toml`."""
        return tuple(name for reader in self._of_all for name in reader.controllers)

    def _readers(self, file: str | None) -> Iterator[_Reader]:
        """Yield what holds settings of a controller, those that go before others last."""
        yield from self._of_all
        script = None if file is None else self._root / file
        if script is not None and script.is_file():
            text = _inline_metadata(script)
            if text is not None:
                yield _Reader(script, text, script.parent, is_own=True)


def loads_toml(text: str) -> dict[str, Any]:
    """Return a TOML document; raise ValueError, with the place, where it is not valid."""
    # Imported here: not every controller has settings.
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib

    try:
        document: dict[str, Any] = tomllib.loads(text)
    except RecursionError as error:
        raise ValueError("it nests too deeply") from error
    return document


def _text(path: Path, errors: str = "strict") -> str:
    try:
        text = file_bytes(path).removeprefix(_BYTE_ORDER_MARK).decode("utf-8", errors)
        return text.replace("\r\n", "\n")
    except OSError as error:
        raise SettingsError(f"cannot be read: {error.strerror}", Location(str(path))) from error
    except ValueError as error:
        raise SettingsError(f"is not valid TOML: {error}", Location(str(path))) from error


def _inline_metadata(path: Path) -> str | None:
    """Return the TOML in a script's block of inline metadata (PEP 723), `None` without settings.

    Its lines keep their numbers: those before the block are empty.
    """
    lines = _text(path, "replace").split("\n")
    begins = [i for i, line in enumerate(lines) if line.rstrip() == _BLOCK_BEGINS]
    names: list[str] = []
    for begin in begins:
        content: list[str] = []
        for line in lines[begin + 1 :]:
            if line.rstrip() != "#" and not line.startswith("# "):
                break
            content.append(line.rstrip())
        if not any(".".join(_TABLE) in line for line in content):
            continue
        place = Location(str(path), begin + 1)
        if _BLOCK_ENDS not in content:
            raise SettingsError(
                f"the block '{_BLOCK_BEGINS}' has no end; put a line '{_BLOCK_ENDS}' below the "
                "settings, and begin each of its lines with '# '",
                place,
            )
        if names:
            raise SettingsError(f"a second block '{_BLOCK_BEGINS}'; keep one", place)
        last = len(content) - 1 - content[::-1].index(_BLOCK_ENDS)
        names = [""] * (begin + 1) + [line[2:] for line in content[:last]]
    return "\n".join(names) if names else None


class _Reader:
    """The settings in one file; `folder` is where the names of files in it start."""

    def __init__(self, path: Path, text: str, folder: Path, *, is_own: bool = False) -> None:
        self._path = path
        self._lines = text.split("\n")
        self._folder = folder
        self._is_own = is_own
        self._place: tuple[str, ...] = _TABLE
        try:
            document = loads_toml(text)
        except ValueError as error:
            raise SettingsError(f"is not valid TOML: {error}", Location(str(path))) from error
        tools = document.get("tool", {})
        self._table: Any = tools.get("tracerisk", {}) if isinstance(tools, dict) else {}

    def values(self, file: str | None) -> dict[str, Any]:
        """Return the settings of a controller that are given here, by name."""
        table = self._table
        if not isinstance(table, dict):
            raise SettingsError("[tool.tracerisk] is not a table", Location(str(self._path)))
        if self._is_own and _CONTROLLERS in table:
            self.fail(_CONTROLLERS, "a controller holds settings of itself alone")
        shared = {key: value for key, value in table.items() if key != _CONTROLLERS}
        values = self._values(shared, _TABLE)
        tables = table.get(_CONTROLLERS, {})
        if not isinstance(tables, dict):
            self.fail(_CONTROLLERS, 'expected tables, [tool.tracerisk.controllers."FILE"]')
        for name, own in tables.items():
            place = (*_TABLE, _CONTROLLERS, name)
            if not isinstance(own, dict):
                self.fail(_CONTROLLERS, f"{name} is not a table of settings")
            if not _is_file(self._folder / name):
                raise SettingsError(
                    f"{_CONTROLLERS}: there is no controller {name} below this file's folder",
                    Location(str(self._path), self._line(None, place)),
                )
            of_one = self._values(own, place)
            if file is not None and PurePosixPath(name) == PurePosixPath(file):
                values.update(of_one)
        return {key: self._placed(key, value) for key, value in values.items()}

    @property
    def controllers(self) -> tuple[str, ...]:
        """The controllers that have a table of their own; `values` checks these tables."""
        return tuple(self._table.get(_CONTROLLERS, {}))

    def origins(self, file: str | None) -> dict[str, SettingOrigin]:
        """Return where the settings of a controller that are given here stand, by name."""
        row = {}
        tables: list[tuple[tuple[str, ...], Any, bool]] = [(_TABLE, self._table, self._is_own)]
        for name, own in self._table.get(_CONTROLLERS, {}).items():
            if file is not None and PurePosixPath(name) == PurePosixPath(file):
                tables.append(((*_TABLE, _CONTROLLERS, name), own, True))
        for place, values, is_own in tables:
            for name in values:
                if name != _CONTROLLERS:
                    line = self._line(name, place)
                    row[_ALIASES.get(name, name)] = SettingOrigin(
                        Location(str(self._path), line), is_own
                    )
        return row

    def _placed(self, key: str, value: Any) -> Any:
        """Return a setting with the names of files as paths."""
        if key in ("params", "drivers", "readable", "writable", "ros_prefixes"):
            return tuple(str(self._folder / _in_home(name)) for name in value)
        if names_file(key, value, self._folder) or (key == "launch" and isinstance(value, str)):
            return str(self._folder / value)
        return value

    def _values(self, table: Mapping[str, Any], place: tuple[str, ...]) -> dict[str, Any]:
        self._place = place
        names = [field.name for field in fields(Settings)]
        for key in table:
            if _ALIASES.get(key) in table:
                self.fail(
                    key, f"is the older name of {_ALIASES[key]}, which is given too; keep one"
                )
            if _ALIASES.get(key, key) not in names:
                allowed = names if place != _TABLE or self._is_own else [*names, _CONTROLLERS]
                self.fail(key, f"unknown setting; {one_of(allowed, key)}")
        return {_ALIASES.get(key, key): self._value(key, value) for key, value in table.items()}

    def _worlds(self, value: Any) -> tuple[str, ...]:
        """Return the names of required worlds; `true` requires all, `false` none."""
        from tracerisk.common.worlds.world import ALL, worlds_named

        is_list = isinstance(value, list) and all(isinstance(name, str) for name in value)
        if not isinstance(value, bool) and not is_list:
            self.fail(
                "require_worlds",
                f"expected true, false or a list of names of worlds, found {value!r}",
            )
        names = ([ALL] if value else []) if isinstance(value, bool) else value
        try:
            return tuple(world.name for world in worlds_named(",".join(names))) if names else ()
        except InputError as error:
            self.fail("require_worlds", error.message)

    def _value(self, key: str, value: Any) -> Any:
        if key in _LISTS:
            if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
                self.fail(key, f"expected a list of {_LISTS[key]}")
            return tuple(value)
        if fraction := FRACTIONS.get(_ALIASES.get(key, key)):
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1:
                self.fail(key, f"expected a {fraction} from 0 to 1, found {value!r}")
            return float(value)
        if key == "tolerance":
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            if not is_number or not 0 <= value <= GREATEST_TOLERANCE:
                self.fail(key, f"expected a number from 0 to {GREATEST_TOLERANCE}, found {value!r}")
            return float(value)
        if key == "accept":
            from tracerisk.common.acceptances import read_acceptances

            return read_acceptances(value, lambda message: self.fail(key, message))
        if key == "require_worlds":
            return self._worlds(value)
        if key in ("require_reason", "companions", "draft", "evidence"):
            if not isinstance(value, bool):
                self.fail(key, f"expected true or false, found {value!r}")
            return value
        if key == "launch":
            if not isinstance(value, bool | str) or value == "":
                self.fail(key, f"expected a launch file, true or false, found {value!r}")
            return value
        for name, choices in (
            ("active", get_args(ActiveMode)),
            ("blocks", get_args(BlockForm)),
            ("fail_on", get_args(FailOn)),
            ("ros_distro", get_args(RosDistro)),
            ("sandbox", get_args(SandboxMode)),
        ):
            if key == name and value not in choices:
                self.fail(key, f"{value!r} is not allowed; {one_of(choices, str(value))}")
        default = DEFAULT_DURATION_S if key == "duration_s" else getattr(Settings(), key)
        if isinstance(default, float):
            if isinstance(value, bool) or not isinstance(value, int | float) or value <= 0:
                self.fail(key, f"expected a number above 0, found {value!r}")
            return float(value)
        if isinstance(default, int):
            if isinstance(value, bool) or not isinstance(value, int) or value < 0:
                self.fail(key, f"expected a whole number from 0 up, found {value!r}")
            if key in FROM_ONE and value < 1:
                self.fail(key, f"expected a whole number from 1 up, found {value!r}")
            return value
        if not isinstance(value, str):
            self.fail(key, f"expected a string, found {value!r}")
        if key == "moveit_release" and not _RELEASE.fullmatch(value):
            self.fail(key, f"expected a release as its package.xml has it, 1.1.15, found {value!r}")
        return value

    def fail(self, key: str, message: str) -> NoReturn:
        """Raise SettingsError for a setting, at its line."""
        place = self._line(key, self._place)
        raise SettingsError(f"{key}: {message}", Location(str(self._path), place))

    def _line(self, key: str | None, table: tuple[str, ...]) -> int | None:
        """Return where `key` of a table stands, or its header; tomllib keeps no positions."""
        in_table = False
        pattern = None if key is None else re.compile(rf"""\s*["']?{re.escape(key)}["']?\s*=""")
        wanted = ".".join(table)
        for number, line in enumerate(self._lines, start=1):
            if line.strip().startswith("["):
                header = line.strip().strip("[] \t").replace('"', "").replace("'", "")
                in_table = header.replace(" ", "") == wanted.replace(" ", "")
                if in_table and pattern is None:
                    return number
            elif in_table and pattern is not None and pattern.match(line):
                return number
        return None


def names_file(setting: str, value: object, base: Path) -> bool:
    """Whether a setting is the path of a file, or of a folder of hardware, seen from `base`."""
    if setting not in _NAMES_OF_FILES or not isinstance(value, str):
        return False
    # A name with an ending is that of a file, be it there or not; no shipped one has it.
    path = base / value
    return _is_file(path) or bool(path.suffix) or (setting == "hardware" and is_folder(path))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # too long for a path
        return False


def _in_home(name: str) -> Path:
    """Return a path with `~` as the home folder; as it is where no user has the name."""
    with contextlib.suppress(RuntimeError):
        return Path(name).expanduser()
    return Path(name)
