"""The texts of interface definitions: `.msg`, and the parts of `.srv` and `.action`.

Those that are shipped stand in one archive for each ROS: behind a line
`=== PACKAGE/KIND/NAME.KIND` follows the text of that file.
"""

from __future__ import annotations

import gzip
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from tracerisk.errors import InputError, Location

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict

_SEPARATOR = "---"
_BEGINS = "=== "
Ros = Literal[1, 2]


@dataclass(frozen=True, slots=True)
class InterfaceText:
    """A definition that is in no file of its own: of an archive, or of a driver's description."""

    ros: Ros | None
    """Whose archive it is of; None for a driver's."""
    package: str
    kind: str
    """`msg`, `srv` or `action`."""
    stem: str
    text: str

    @property
    def name(self) -> str:
        """The name of its file."""
        return f"{self.stem}.{self.kind}"

    def __str__(self) -> str:
        return f"{self.package}/{self.kind}/{self.name}"


Definition = Path | InterfaceText
"""Where the text of a definition is."""
ByPackage = Mapping[tuple[str, str], tuple[InterfaceText, ...]]
"""Definitions by package and kind."""


def _archive(path: Path) -> str:
    """Return the text of an archive, which a wheel has compressed."""
    if path.exists():
        return path.read_text(encoding="utf-8")
    return gzip.decompress(path.with_name(f"{path.name}.gz").read_bytes()).decode("utf-8")


@cache
def shipped_texts(ros: Ros) -> ByPackage:
    """Return the definitions of one ROS's archive by package and kind, sorted by name."""
    archive = _archive(Path(__file__).with_name(f"interfaces{ros}.txt"))
    found = []
    for entry in f"\n{archive.rstrip()}".split(f"\n{_BEGINS}")[1:]:
        place, _, text = entry.partition("\n")
        package, kind, name = place.split("/")
        stem = name.removesuffix(f".{kind}")
        found.append(InterfaceText(ros, package, kind, stem, f"{text}\n"))
    return by_package(found)


def by_package(texts: Iterable[InterfaceText]) -> ByPackage:
    """Return definitions by package and kind, in their order."""
    found: dict[tuple[str, str], tuple[InterfaceText, ...]] = {}
    for each in texts:
        key = each.package, each.kind
        found[key] = (*found.get(key, ()), each)
    return found


def shipped_packages(ros: Ros) -> set[str]:
    """Return the names of the packages in one ROS's archive."""
    return {package for package, _ in shipped_texts(ros)}


def interface_text(definition: Definition) -> str:
    """Return the text of a definition; letters that are not UTF-8 can only stand in comments."""
    if isinstance(definition, InterfaceText):
        return definition.text
    return definition.read_text(encoding="utf-8", errors="replace")


@cache
def parsed(text: str, name: str) -> Any:
    """Return the constants and the fields of a message `package/msg/Name`, as rosbags has them.

    Raises:
        rosbags.typesys.TypesysError: the text is no definition.
    """
    from rosbags.typesys import get_types_from_msg

    return get_types_from_msg(text, name)[name]


def field_comments(definition: Definition) -> dict[str, str]:
    """Return the comments of the fields before the first line `---`: beside them, or just above."""
    found: dict[str, str] = {}
    above: list[str] = []
    for line in interface_text(definition).splitlines():
        code, _, comment = line.partition("#")
        if code.strip() == _SEPARATOR:
            break
        words = code.split()
        if len(words) > 1 and "=" not in code:
            found[words[1]] = comment.strip() or " ".join(above)
        above = [*above, comment.strip()] if not words and comment else []
    return found


def interface_parts(definition: Definition, count: int) -> list[str]:
    """Return the parts of a definition between its lines `---`.

    Raises:
        InputError: there are more or fewer than `count`.
    """
    parts: list[list[str]] = [[]]
    for line in interface_text(definition).splitlines():
        if line.strip() == _SEPARATOR:
            parts.append([])
        else:
            parts[-1].append(line)
    if len(parts) != count:
        raise InputError(
            f"{len(parts)} parts between lines '{_SEPARATOR}', {count} expected",
            Location(str(definition)),
        )
    return ["\n".join(part) + "\n" for part in parts]


class InterfaceStore:
    """The definitions that are known, and the classes made of them so far.

    `workspace` maps a package's name to the folder that holds its `msg`, `srv` and `action`;
    `more` are definitions that count where no other of that name is found.
    """

    def __init__(
        self,
        workspace: Mapping[str, Path] | None = None,
        more: Iterable[InterfaceText] = (),
    ) -> None:
        self._workspace = dict(workspace or {})
        self._more = by_package(more)
        self._definitions: Typesdict = {}
        self._classes: dict[str, Any] = {}
        self._services: dict[str, Any] = {}
        self._actions: dict[str, Any] = {}
        self._listed: dict[tuple[str, str], dict[str, Definition]] = {}

    @property
    def workspace(self) -> Mapping[str, Path]:
        """The folders of the controller's own packages."""
        return self._workspace

    def service_names(self, package: str) -> tuple[str, ...]:
        """Return the names of a package's services, sorted."""
        return tuple(sorted(self._files(package, "srv")))

    def is_used(self, package: str) -> bool:
        """Return whether the controller has a package in its workspace or used a class of it."""
        made = (*self._classes, *self._services, *self._actions)
        return package in self._workspace or any(name.startswith(f"{package}/") for name in made)

    def comments(self, name: str, kind: str) -> dict[str, str]:
        """Return the comments beside the fields of a message, a request or a goal."""
        package, _, short = name.partition("/")
        found = self._files(package, kind).get(short)
        return {} if found is None else field_comments(found)

    def _files(self, package: str, kind: str) -> dict[str, Definition]:
        """Return a package's definitions of a kind by their names."""
        key = package, kind
        if key not in self._listed:
            # Asked for at each name of a package, of which some have hundreds.
            found: dict[str, Definition] = {each.stem: each for each in self._more.get(key, ())}
            if package in self._workspace:
                # Some packages sort them into folders, which the names of the classes leave out.
                found |= _in_folder(self._workspace[package] / kind, f"**/*.{kind}")
            else:
                found |= {each.stem: each for each in self._shipped(package, kind)}
            self._listed[key] = found
        return self._listed[key]

    def _shipped(self, package: str, kind: str) -> Iterable[InterfaceText]:
        """Return the definitions that are shipped; of one name the last is meant."""
        return shipped_texts(1).get((package, kind), ())


def _in_folder(folder: Path, pattern: str) -> dict[str, Definition]:
    """Return the files in a folder by their stems; of several, the first."""
    return {path.stem: path for path in sorted(folder.glob(pattern), reverse=True)}
