"""The texts of interface definitions: `.msg`, and the parts of `.srv` and `.action`.

Those that are shipped stand in one archive for each ROS: behind a line
`=== PACKAGE/KIND/NAME.KIND` follows the text of that file.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

from tracerisk.errors import InputError, Location

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


@cache
def shipped_texts(ros: Ros) -> ByPackage:
    """Return the definitions of one ROS's archive by package and kind, sorted by name."""
    archive = Path(__file__).with_name(f"interfaces{ros}.txt").read_text(encoding="utf-8")
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
