"""Where descriptions of drivers are: with tracerisk, in installed packages, in the workspace."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from tracerisk.errors import DriverError
from tracerisk.ros.messages.interface_texts import InterfaceText
from tracerisk.ros.vendors.description import Driver
from tracerisk.ros.vendors.description_reader import read_driver

ENDING = ".driver.yaml"
"""How the names of files end that describe a driver: `acme.driver.yaml`."""
ENTRY_POINTS = "tracerisk.drivers"
"""The entry points of installed packages; each names a package that holds descriptions."""

_HERE = Path(__file__).parent


def shipped_files() -> tuple[Path, ...]:
    """Return the descriptions that tracerisk ships, sorted."""
    return tuple(sorted(_HERE.glob(f"*/*{ENDING}")))


@cache
def shipped_drivers() -> tuple[Driver, ...]:
    """Return the drivers that tracerisk describes, sorted by their files."""
    return tuple(
        read_driver(path, shown=path.relative_to(_HERE).as_posix(), origin="shipped")
        for path in shipped_files()
    )


def read_drivers(files: Iterable[Path], root: Path) -> tuple[Driver, ...]:
    """Read the descriptions in files, whose names are given from a controller's root.

    Raises DriverError as `read_driver`.
    """
    if not (files := tuple(files)):
        return ()
    installed = set(installed_files())
    return tuple(
        read_driver(
            file,
            shown=os.path.relpath(file, root),
            origin="installed" if file in installed else "user",
        )
        for file in files
    )


def installed_files() -> tuple[Path, ...]:
    """Return the descriptions that installed packages bring, in the order of their names.

    Raises:
        DriverError: an entry point names a package that is not there or that holds none.
    """
    return _installed_files(tuple(sys.path))


@cache
def _installed_files(_places: tuple[str, ...]) -> tuple[Path, ...]:
    """Look for them once: every run asks several times, and each reads a file of every package."""
    from importlib.metadata import entry_points

    installed_files: list[Path] = []
    for point in sorted(entry_points(group=ENTRY_POINTS), key=lambda entry_point: entry_point.name):
        try:
            spec = find_spec(point.value)
        except (ImportError, ValueError, AttributeError):
            spec = None
        folders = [] if spec is None else list(spec.submodule_search_locations or ())
        files = [path for folder in folders for path in sorted(Path(folder).glob(f"*{ENDING}"))]
        if not files:
            raise DriverError(
                f"entry point '{point.name}' of {ENTRY_POINTS} names '{point.value}', which is no "
                f"package with a file *{ENDING}"
            )
        installed_files += files
    return tuple(installed_files)


def definitions_of(drivers: Iterable[Driver]) -> tuple[InterfaceText, ...]:
    """Return the messages that descriptions define; of those of one name, the last."""
    texts = {name: text for driver in drivers for name, text in driver.definitions.items()}
    definitions = []
    for name, text in sorted(texts.items()):
        package, kind, stem = name.split("/")
        definitions.append(InterfaceText(package, kind, stem, text))
    return tuple(definitions)
