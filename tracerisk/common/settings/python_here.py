"""The Python of this process: where it is installed, and whether something else has changed it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from tracerisk.common.text.bounded import MOST_OF_A_RUN, file_bytes
from tracerisk.common.text.digests import sha256

CHANGED_PYTHON = "changed_python"
"""The name under which the lock keeps `changed_python()`, among the settings of a run."""
_OF_PYTHON = frozenset({"sitecustomize", "usercustomize", *sys.stdlib_module_names})


def foreign_folders() -> tuple[Path, ...]:
    """Return tracerisk's own folder and those of the standard library and of what is installed."""
    import site  # not needed to check whether a trace is fresh, which must be quick
    import sysconfig

    names = ("stdlib", "platstdlib", "purelib", "platlib")
    folders = [*map(sysconfig.get_path, names), *site.getsitepackages(), site.getusersitepackages()]
    installed = {Path(folder).resolve() for folder in folders}
    return (Path(__file__).resolve().parents[2], *sorted(installed))


def changed_python() -> list[str]:
    """Return the modules of Python's own that this process has from elsewhere, with digests.

    As `PYTHONPATH` gives them: all that is computed here depends on them.
    Raises InputError or OSError where one cannot be read.
    """
    own = f"{Path(os.__file__).parent}{os.sep}"
    files = (
        (name, getattr(sys.modules[name], "__file__", None))
        for name in sorted(_OF_PYTHON & sys.modules.keys())
    )
    strange = [(name, Path(file)) for name, file in files if file and not file.startswith(own)]
    if not strange:
        return []
    folders = foreign_folders()
    return [
        f"{name} {sha256(file_bytes(file, MOST_OF_A_RUN))}"
        for name, file in strange
        if not any(file.resolve().is_relative_to(folder) for folder in folders)
    ]
