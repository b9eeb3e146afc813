"""The descriptions of drivers that a controller gets: of its settings, workspace, environment."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.config import Settings
from tracerisk.errors import DriverError
from tracerisk.pipeline.workspace.package_folders import NOT_SEARCHED
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import TESTS, searched
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.vendors.description_reader import read_driver
from tracerisk.ros.vendors.driver_search import (
    ENDING,
    definitions_of,
    installed_files,
    shipped_drivers,
    shipped_files,
)

if TYPE_CHECKING:
    from tracerisk.ros.vendors.description import Driver

_MOST_FOLDERS = 5000


def driver_files(project: Project, settings: Settings) -> tuple[Path, ...]:
    """Return the files that describe drivers; those that come first go before the others.

    They are those that the settings name, those of the workspace around the controller in the
    order of their paths, and those of installed packages.
    Raises DriverError for an entry point that names no descriptions.
    """
    named = [Path(name).resolve() for name in settings.drivers]
    fromkeys = dict.fromkeys([*named, *_in_workspace(project.top), *installed_files()])
    return tuple(fromkeys)


def check_driver(path: Path) -> Driver:
    """Read a description and check its fields against the messages of the workspace around it.

    Raises DriverError with file and line for all that is not allowed.
    """
    # A run needs the names of the files alone.
    from tracerisk.ros.messages.ros1 import Interfaces
    from tracerisk.ros.messages.ros2 import Interfaces2

    driver = read_driver(path)
    own = Project.of(path).workspace().interfaces
    more = definitions_of((*shipped_drivers(), driver))
    failures = []
    for make in (Interfaces2, Interfaces):
        try:
            _check(driver, TwinMessages(make(workspace=own, more=more)))
        except DriverError as error:
            failures.append(error)
        else:
            return driver
    # A package is of one ROS: what its own says is what its author wants to know.
    raise min(failures, key=lambda error: "no message package" in error.message)


def _check(driver: Driver, messages: TwinMessages) -> None:
    from tracerisk.ros.vendors.interface_checks import (
        check_interface,
        types_in_use,
        unknown_package,
    )

    for interface in driver.interfaces:
        for type_name in types_in_use(driver, interface, messages):
            check_interface(interface, type_name, messages)
    if driver.interfaces and not any(
        types_in_use(driver, interface, messages) for interface in driver.interfaces
    ):
        raise unknown_package(driver.interfaces[0])


def _in_workspace(top: Path) -> list[Path]:
    # A checkout of tracerisk itself holds those that it ships.
    shipped = {path.parts[-3:] for path in shipped_files()}
    paths: list[Path] = []
    for folder, files in itertools.islice(searched(top, NOT_SEARCHED | TESTS), _MOST_FOLDERS):
        paths += [Path(folder, name) for name in files if name.endswith(ENDING)]
    return sorted(path for path in paths if path.parts[-3:] not in shipped)
