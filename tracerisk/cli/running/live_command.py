"""What stands behind `--live --`: a command, which may name its source in one way or another."""

from __future__ import annotations

import argparse
import os
import re
import shutil
from pathlib import Path

from tracerisk.common.text.bounded import files_below, regular_file
from tracerisk.errors import InputError
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.launch.program import program_of
from tracerisk.pipeline.workspace.project import Project

_ELF = b"\x7fELF"
_MOST_OF_LINE = 200  # bytes
_PYTHON = re.compile(r"python(3(\.\d+)?)?")
_N_NAMED = 3  # the words that `ros2 run` needs: run, package, executable


def name_source(options: argparse.Namespace) -> None:
    """Make the source the controller where a command was given in its place.

    `run --live -- ./pick --fast` is `run pick.cpp --live -- ./pick --fast` then, and
    `run --live -- python3 pick.py --fast`, or `ros2 run cell pick --fast`, is
    `run pick.py --live -- --fast`.

    Raises:
        InputError: the command is no executable, or nothing says which source it runs.
    """
    given = options.controller
    if not options.live or given is None or _is_source(Path(given)):
        return
    named = _by_name([given, *options.argv], options.verb)
    if named is not None and _is_source(named[0]):
        options.controller, options.argv = os.path.relpath(named[0]), named[1]
        return
    command = " ".join([given, *options.argv])
    remedy = f"name the source with main() before --live: `tracerisk {options.verb} FILE.cpp --live"
    program = shutil.which(given) if named is None else str(named[0])
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

    # What reads binaries loads `ctypes`, and few runs are given one.
    from tracerisk.instrument.native.binaries import Binary

    file = Binary(program).file_of("main")
    if not file or not Path(file).is_file():
        there = (
            f"was built from {file}, which is not there: build it again"
            if file
            else "does not say from which source it was built: compile with -g, with addr2line of "
            "binutils installed"
        )
        what = given if named is None else named[0]
        raise InputError(f"{what} {there}, or {remedy} -- {command}`")
    options.controller = os.path.relpath(file)
    options.argv = [given, *options.argv]


def _by_name(words: list[str], verb: str) -> tuple[Path, list[str]] | None:
    """Return the script or executable that `python3` or `ros2 run` starts, and its arguments.

    None for any other command.
    """
    program, *rest = words
    if _PYTHON.fullmatch(Path(program).name):
        if rest and _is_source(Path(rest[0])):
            return Path(rest[0]), rest[1:]
        raise InputError(
            f"after {program} a live run takes the path of a script and its arguments, no options "
            f"of Python: `tracerisk {verb} FILE.py --live -- ARGUMENTS`"
        )
    if Path(program).name != "ros2":
        return None
    if rest[:1] != ["run"] or len(rest) < _N_NAMED or rest[1].startswith("-"):
        raise InputError(
            "of ros2, a live run takes `ros2 run PACKAGE EXECUTABLE ARGUMENTS`; for a launch file, "
            f"name the script and what starts it: `tracerisk {verb} FILE.py --live --launch FILE`, "
            f"or the source of a compiled node: `tracerisk {verb} FILE.cpp --live -- "
            f"{' '.join(words)}`"
        )
    return _program_of(rest[1], rest[2], verb), rest[3:]


def _program_of(package: str, executable: str, verb: str) -> Path:
    """Return the script of an executable of ROS 2, from the sources below here or an install.

    Of a compiled node, return the executable itself.
    """
    here = Path.cwd()
    workspace = Project(here).workspace(2)
    folder = workspace.packages.get(package)
    for script in () if folder is None else files_below(folder, ".py"):
        if executable in program_of(script, here, workspace).names:
            return script
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        installed = Path(prefix, "lib", package, executable)
        if prefix and (_is_source(installed) or _begin(installed).startswith(_ELF)):
            return installed
    raise InputError(
        f"no executable {executable} of a package {package} is below {here}, nor in a prefix of "
        f"AMENT_PREFIX_PATH; name it: `tracerisk {verb} FILE.py --live -- ARGUMENTS`"
    )


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
