"""What stands behind `--live --`: a command, whose source its debug information may name."""

from __future__ import annotations

import argparse
import os
import shutil
from pathlib import Path

from tracerisk.common.text.bounded import regular_file
from tracerisk.errors import InputError
from tracerisk.instrument.native.binaries import Binary
from tracerisk.instrument.source.language import is_c

_ELF = b"\x7fELF"
_MOST_OF_LINE = 200  # bytes


def name_source(options: argparse.Namespace) -> None:
    """Make the source with `main()` the controller where a command was given in its place.

    `run --live -- ./pick --fast` is `run pick.cpp --live -- ./pick --fast` then.

    Raises:
        InputError: the command is no executable, or its debug information names no source.
    """
    given = options.controller
    if not options.live or given is None or _is_source(Path(given)):
        return
    command = " ".join([given, *options.argv])
    remedy = f"name the source with main() before --live: `tracerisk {options.verb} FILE.cpp --live"
    program = shutil.which(given)
    if program is None and not Path(given).exists():
        raise InputError(
            f"the program {given} is not there; build it, source setup.bash of its workspace, or "
            "give its path"
        )
    if program is None or not _begin(Path(program)).startswith(_ELF):
        raise InputError(
            f"{given} is neither a Python program nor the executable of a node, so what it runs is "
            f"not known; {remedy} -- {command}`"
        )

    file = Binary(program).file_of("main")
    if not file or not Path(file).is_file():
        there = (
            f"was built from {file}, which is not there: build it again"
            if file
            else "does not say from which source it was built: compile with -g, with addr2line of "
            "binutils installed"
        )
        raise InputError(f"{given} {there}, or {remedy} -- {command}`")
    options.controller = os.path.relpath(file)
    options.argv = [given, *options.argv]


def _is_source(path: Path) -> bool:
    first = _begin(path).partition(b"\n")[0]
    is_script = first.startswith(b"#!") and b"python" in first
    return path.suffix in (".py", ".pyw") or is_c(path.name) or is_script


def _begin(path: Path) -> bytes:
    try:
        with regular_file(path) as stream:
            return stream.read(_MOST_OF_LINE)
    except OSError:
        return b""
