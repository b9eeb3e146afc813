"""Compiles the probe that is preloaded into compiled nodes, by the compiler of the machine."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
from pathlib import Path

from tracerisk.errors import DependencyError, Location

NAME = "libtracerisk_calls.so"
FLAGS = ("-std=gnu11", "-O2", "-fPIC", "-shared", "-fexceptions", "-fvisibility=hidden")
LIBRARIES = ("-ldl", "-lgcc_s")
COMPILERS = ("cc", "gcc", "clang")
"""What is looked for where the variable CC says nothing."""
_HERE = Path(__file__)
_SOURCES = (_HERE.with_name("calls.c"), _HERE.parents[3] / "probe/native/calls.c")
"""In an installed package, and in the repository."""


def build_probe(folder: Path) -> Path:
    """Compile the probe into a folder; return the library for `LD_PRELOAD`.

    Raises:
        DependencyError: if there is no C compiler, or it fails.
    """
    source = next(path for path in _SOURCES if path.is_file())
    compiler = (
        shlex.split(os.environ.get("CC", ""))
        or [name for name in COMPILERS if shutil.which(name)][:1]
    )
    if not compiler:
        raise DependencyError(
            "a compiled node is recorded by a library that a C compiler makes, and there is "
            f"none of {', '.join(COMPILERS)}; install one, such as the package gcc"
        )
    library = folder / NAME
    made = library.with_suffix(".new")  # the old one may be in use
    try:
        done = subprocess.run(
            [*compiler, *FLAGS, str(source), "-o", str(made), *LIBRARIES],
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            check=False,
        )
    except OSError as error:
        raise DependencyError(
            f"the compiler {compiler[0]} cannot be run ({error.strerror}); set CC to another"
        ) from error
    if done.returncode:
        words = next(iter(done.stderr.splitlines()), f"it ended with {done.returncode}")
        raise DependencyError(
            f"the compiler {compiler[0]} failed: {words}; set CC to another", Location(str(source))
        )
    made.replace(library)
    return library
