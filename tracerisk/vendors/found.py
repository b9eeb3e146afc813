"""Where descriptions of drivers are: with tracerisk, in installed packages, in the workspace."""

from __future__ import annotations

from functools import cache
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from tracerisk.errors import DriverError
from tracerisk.vendors.description import Driver
from tracerisk.vendors.description_reader import read_driver

ENDING = ".driver.yaml"
"""How the names of files end that describe a driver: `acme.driver.yaml`."""
ENTRY_POINTS = "tracerisk.drivers"
"""The entry points of installed packages; each names a package that holds descriptions."""

_HERE = Path(__file__).parent


@cache
def shipped_drivers() -> tuple[Driver, ...]:
    """Return the drivers that tracerisk describes, sorted by their files."""
    return tuple(
        read_driver(path, shown=path.relative_to(_HERE).as_posix(), is_shipped=True)
        for path in sorted(_HERE.glob(f"*/*{ENDING}"))
    )


def installed_files() -> tuple[Path, ...]:
    """Return the descriptions that installed packages bring, in the order of their names.

    Raises:
        DriverError: an entry point names a package that is not there or that holds none.
    """
    found: list[Path] = []
    for point in sorted(entry_points(group=ENTRY_POINTS), key=lambda each: each.name):
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
        found += files
    return tuple(found)
