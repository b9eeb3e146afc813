"""The descriptions of drivers that a controller gets: of its settings, workspace, environment."""

from __future__ import annotations

import itertools
import os
from pathlib import Path

from tracerisk.config import Settings
from tracerisk.pipeline.workspace import project_top
from tracerisk.vendors.found import ENDING, installed_files

_MOST_FOLDERS = 5000
_NOT_SEARCHED = frozenset({"build", "devel", "install", "log", "node_modules", "__pycache__"})


def driver_files(root: Path, settings: Settings) -> tuple[Path, ...]:
    """Return the files that describe drivers; those that come first go before the others.

    They are those that the settings name, those of the workspace around the controller in the
    order of their paths, and those of installed packages.
    Raises DriverError for an entry point that names no descriptions.
    """
    named = [Path(name).resolve() for name in settings.drivers]
    found = dict.fromkeys([*named, *_in_workspace(project_top(root)), *installed_files()])
    return tuple(found)


def _in_workspace(top: Path) -> list[Path]:
    found: list[Path] = []
    for folder, folders, files in itertools.islice(os.walk(top), _MOST_FOLDERS):
        folders[:] = sorted(
            each for each in folders if not each.startswith(".") and each not in _NOT_SEARCHED
        )
        found += [Path(folder, name) for name in files if name.endswith(ENDING)]
    return sorted(found)
