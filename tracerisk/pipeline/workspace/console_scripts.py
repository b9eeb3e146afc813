"""The commands that a Python package installs: of which function, and which file says so."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tracerisk.common.settings.settings_file import loads_toml
from tracerisk.common.text.bounded import file_text

# Bounded throughout, so that no text takes long.
# "talker = my_package.talker:main"; the package may be a variable, as in f"{package}.talker:main".
_ENTRY = re.compile(
    r"(?P<name>(?<![\w.-])[\w.-]{0,200})\s{0,20}=\s{0,20}"
    r"[\w.{}'\"+ ]{0,200}?\b(?P<module>\w{1,200})\s{0,20}:\s{0,20}"
    r"(?P<function>[A-Za-z_]\w{0,200})\s{0,20}(?:['\"\n\]]|$)"
)


@dataclass(frozen=True, slots=True)
class ConsoleScript:
    """A command that a package installs."""

    name: str
    """The name of the command; empty where the source puts it together."""
    module: str
    """The last name of its module."""
    function: str
    """The function that it calls."""
    file: str
    """The name of the file that defines it, such as `setup.py`."""


def console_scripts(folder: Path) -> Iterator[ConsoleScript]:
    """Yield what `setup.py`, `setup.cfg` and `pyproject.toml` in a folder install as commands.

    What cannot be read, or is not a list of commands, names none.
    """
    for file in ("setup.py", "setup.cfg"):
        for match_ in _ENTRY.finditer(read_or_nothing(folder / file)):
            yield ConsoleScript(match_["name"], match_["module"], match_["function"], file)
    file = "pyproject.toml"
    try:
        document = loads_toml(read_or_nothing(folder / file))
        for name, entry in document.get("project", {}).get("scripts", {}).items():
            place, _, function = str(entry).partition(":")
            yield ConsoleScript(name, place.strip().rpartition(".")[2], function.strip(), file)
    except (ValueError, AttributeError):
        return


def read_or_nothing(path: Path) -> str:
    """Return the text of a file, an empty one where it cannot be read."""
    try:
        return file_text(path, errors="replace")
    except OSError:
        return ""
