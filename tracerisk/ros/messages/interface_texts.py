"""The texts of interface definitions: `.msg`, and the parts of `.srv` and `.action`."""

from __future__ import annotations

from pathlib import Path

from tracerisk.errors import InputError, Location

_SEPARATOR = "---"


def interface_text(path: Path) -> str:
    """Return the text of a definition; letters that are not UTF-8 can only stand in comments."""
    return path.read_text(encoding="utf-8", errors="replace")


def interface_parts(path: Path, count: int) -> list[str]:
    """Return the parts of a definition between its lines `---`.

    Raises:
        InputError: there are more or fewer than `count`.
    """
    parts: list[list[str]] = [[]]
    for line in interface_text(path).splitlines():
        if line.strip() == _SEPARATOR:
            parts.append([])
        else:
            parts[-1].append(line)
    if len(parts) != count:
        raise InputError(
            f"{len(parts)} parts between lines '{_SEPARATOR}', {count} expected",
            Location(str(path)),
        )
    return ["\n".join(part) + "\n" for part in parts]
