"""The preloaded probe of compiled nodes, built on the machine on which they run."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

import tracerisk
from tracerisk.errors import DependencyError

LIBRARY = "TRACERISK_PROBE"
"""The environment variable that names a probe which is built already."""
_PACKAGE = Path(tracerisk.__file__).parent
_SOURCES = (
    _PACKAGE / "instrument" / "native" / "calls.c",
    _PACKAGE.parent / "probe" / "native" / "calls.c",
)
"""Where its source is: in an installed package, and in the repository."""
_FLAGS = ("-O2", "-fPIC", "-shared", "-fexceptions")
_LIBRARIES = ("-ldl", "-lgcc_s")


def built_probe(environment: Mapping[str, str], folder: Path) -> Path | None:
    """Return the probe that the environment names, else one that is built in `folder`.

    `None` where there is no C compiler (the variable `CC`, or `cc`), or no source.

    Raises:
        DependencyError: the environment names no file, or the compiler fails.
    """
    named = environment.get(LIBRARY)
    if named:
        if not Path(named).is_file():
            raise DependencyError(
                f"{LIBRARY} names {named}, where no file is; build it as probe/README.md says, or "
                "leave the variable out"
            )
        return Path(named).absolute()
    source = next((path for path in _SOURCES if path.is_file()), None)
    compiler = shutil.which(environment.get("CC") or "cc", path=environment.get("PATH", os.defpath))
    if source is None or compiler is None:
        return None
    library = folder / "libtracerisk_calls.so"
    command = [compiler, *_FLAGS, "-o", str(library), str(source), *_LIBRARIES]
    done = subprocess.run(
        command, capture_output=True, text=True, errors="replace", check=False, env=environment
    )
    if done.returncode:
        said = (done.stderr.strip().splitlines() or ["it said nothing"])[0]
        raise DependencyError(f"the probe cannot be built: `{' '.join(command)}` fails: {said}")
    return library
