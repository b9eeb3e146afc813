"""A Python of its own that finds some folders before everything that is installed.

No variable of the environment does that: a process that runs what is a stranger's heeds none.
"""

import sys
import venv
from pathlib import Path

import tracerisk


def python_with(folder: Path, *first: Path, at_start: str | None = None) -> Path:
    """Make an environment in `folder` and return its interpreter.

    It imports from the folders `first`, and then from where this process does. It imports the
    module `at_start` whenever it starts.
    """
    venv.create(folder, symlinks=True, with_pip=False)
    program = folder / "bin" / "python"
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    installed = [each for each in sys.path if each.endswith("-packages")]
    paths = [*first, Path(tracerisk.__file__).parents[1], *installed]
    listed = folder / "lib" / version / "site-packages" / "all.pth"
    lines = [*map(str, paths), *([] if at_start is None else [f"import {at_start}"])]
    listed.write_text("".join(f"{each}\n" for each in lines), encoding="utf-8")
    return program
