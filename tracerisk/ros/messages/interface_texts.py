"""The texts of interface definitions: `.msg`, and the parts of `.srv` and `.action`.

Those that are shipped stand in one archive for each ROS: behind a line
`=== PACKAGE/KIND/NAME.KIND` follows the text of that file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

from tracerisk.errors import InputError, Location

_SEPARATOR = "---"
_BEGINS = "=== "
Ros = Literal[1, 2]


@dataclass(frozen=True, slots=True)
class ShippedText:
    """A definition of an archive."""

    ros: Ros
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


Definition = Path | ShippedText
"""Where the text of a definition is."""


@cache
def shipped_texts(ros: Ros) -> Mapping[tuple[str, str], tuple[ShippedText, ...]]:
    """Return the definitions of one ROS's archive by package and kind, sorted by name."""
    archive = Path(__file__).with_name(f"interfaces{ros}.txt").read_text(encoding="utf-8")
    found: dict[tuple[str, str], tuple[ShippedText, ...]] = {}
    for entry in f"\n{archive.rstrip()}".split(f"\n{_BEGINS}")[1:]:
        place, _, text = entry.partition("\n")
        package, kind, name = place.split("/")
        definition = ShippedText(ros, package, kind, name.removesuffix(f".{kind}"), f"{text}\n")
        found[package, kind] = (*found.get((package, kind), ()), definition)
    return found


def shipped_packages(ros: Ros) -> set[str]:
    """Return the names of the packages in one ROS's archive."""
    return {package for package, _ in shipped_texts(ros)}


def interface_text(definition: Definition) -> str:
    """Return the text of a definition; letters that are not UTF-8 can only stand in comments."""
    if isinstance(definition, ShippedText):
        return definition.text
    return definition.read_text(encoding="utf-8", errors="replace")


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
