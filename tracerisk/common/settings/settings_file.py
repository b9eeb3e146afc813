"""Read the settings that one file gives, and say at which line a bad one stands."""

from __future__ import annotations

import contextlib
import re
import sys
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple, NoReturn, get_args

from tracerisk.common.text.bounded import is_folder
from tracerisk.config import (
    DEFAULT_DURATION_S,
    ActiveMode,
    BlockForm,
    FailOn,
    RosDistro,
    SandboxMode,
    Settings,
)
from tracerisk.errors import InputError, Location, SettingsError, one_of

GREATEST_TOLERANCE = 0.05
"""The greatest `tolerance` that may be set."""

FRACTIONS = {
    "max_failure_probability": "probability",
    "max_undetected_probability": "probability",
    "min_coverage": "fraction",
}
"""The settings that are numbers from 0 to 1, and what each is called."""

FROM_ONE = ("mission_cycles", "evidence_cells")
"""The whole numbers that begin at 1; the others begin at 0."""

TABLE = ("tool", "tracerisk")
"""The names of the table that holds the settings, from the outside in."""

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


class SettingOrigin(NamedTuple):
    """Where a setting comes from."""

    location: Location | None = None
    """The line that sets it; `None` for a default."""
    is_own: bool = False
    """Whether it is set for this controller alone, in its own table or in its file."""


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


class SettingsFile:
    """The settings in one file; `folder` is where the names of files in it start."""

    def __init__(self, path: Path, text: str, folder: Path, *, is_own: bool = False) -> None:
        self._path = path
        self._lines = text.split("\n")
        self._folder = folder
        self._is_own = is_own
        self._place: tuple[str, ...] = TABLE
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
        values = self._values(shared, TABLE)
        tables = table.get(_CONTROLLERS, {})
        if not isinstance(tables, dict):
            self.fail(_CONTROLLERS, 'expected tables, [tool.tracerisk.controllers."FILE"]')
        for name, own in tables.items():
            place = (*TABLE, _CONTROLLERS, name)
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
        tables: list[tuple[tuple[str, ...], Any, bool]] = [(TABLE, self._table, self._is_own)]
        for name, own in self._table.get(_CONTROLLERS, {}).items():
            if file is not None and PurePosixPath(name) == PurePosixPath(file):
                tables.append(((*TABLE, _CONTROLLERS, name), own, True))
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
                allowed = names if place != TABLE or self._is_own else [*names, _CONTROLLERS]
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
