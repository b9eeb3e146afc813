"""The settings: `[tool.tracerisk]` of the `pyproject.toml` at a controller's root, and its own.

A controller may carry settings of its own in a block of inline script metadata (PEP 723).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

from tracerisk.common.settings.settings_file import TABLE, SettingOrigin, SettingsFile
from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import Settings
from tracerisk.errors import Location, SettingsError

_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_BLOCK_BEGINS = "# /// script"
_BLOCK_ENDS = "# ///"


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
        self._of_all = [SettingsFile(path, _text(path), root)] if path.is_file() else []

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

    def _readers(self, file: str | None) -> Iterator[SettingsFile]:
        """Yield what holds settings of a controller, those that go before others last."""
        yield from self._of_all
        script = None if file is None else self._root / file
        if script is not None and script.is_file():
            text = _inline_metadata(script)
            if text is not None:
                yield SettingsFile(script, text, script.parent, is_own=True)


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
        if not any(".".join(TABLE) in line for line in content):
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
