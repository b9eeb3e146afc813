"""Start processes of ours apart from everything around them, contained where that is asked for.

No current folder, no folder of a user and no variable of the environment decides what they import.
That is Python's isolated mode but for the seed of hashes, which isolated mode does not let us set.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import sysconfig
import tempfile
import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache, partial
from importlib.util import cache_from_source
from pathlib import Path
from typing import Any

from tracerisk.common.limits import Sandbox
from tracerisk.common.sandbox.fork_server import OF_LIBRARIES, forked, is_ready
from tracerisk.common.sandbox.kernel.features import support
from tracerisk.common.sandbox.readable_parts import (
    _INSTALLED,
    _SOURCE_ENDINGS,
    _SYSTEM,
    readable_parts,
)
from tracerisk.common.sandbox.ros_prefix import without_ros
from tracerisk.errors import SandboxError

_PACKAGE = Path(__file__).resolve().parents[2]
_START = Path(__file__).with_name("start.py")
_GRACE_S = 5.0

_PASSED = frozenset(
    {
        *("HOME", "LANG", "LANGUAGE", "LD_LIBRARY_PATH", "LOGNAME", "PATH", "SHELL", "TERM"),
        *("TMPDIR", "TZ", "USER", "VIRTUAL_ENV", "COLUMNS", "LINES"),
    }
)
_OF_HOST = ("ROS_", "AMENT_", "CATKIN_", "CMAKE_PREFIX_PATH", "COLCON_", "RMW_")
_LIBRARIES = "LD_LIBRARY_PATH"


OF_FORKED = {
    "stdin": subprocess.DEVNULL,
    "stdout": subprocess.PIPE,
    "stderr": subprocess.STDOUT,
}
"""What `subprocess.Popen` is given for a process that a server may fork."""


class _Started(subprocess.Popen[bytes]):
    """A process that was started afresh."""

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end, at most for a time [s], asleep: `Popen` itself would look for it.

        Raises TimeoutExpired after that.
        """
        if timeout and self.returncode is None and sys.platform == "linux":
            with contextlib.suppress(AttributeError, OSError):  # where there is no such descriptor
                end_of_it = os.pidfd_open(self.pid)
                try:
                    is_ready(end_of_it, timeout)
                finally:
                    os.close(end_of_it)
                timeout = 0.0
        return super().wait(timeout)


class SandboxWarning(UserWarning):
    """Strangers' code runs uncontained."""


def is_contained(sandbox: Sandbox) -> bool:
    """Return whether a sandbox contains here; warns once where it should and cannot.

    Raises SandboxError where it is required and cannot.
    """
    if sandbox.mode == "off":
        return False
    missing = support().missing
    if not missing:
        return True
    if sandbox.mode == "require":
        raise SandboxError(
            f"the sandbox is required and does not work here: {missing} is missing; "
            "tracerisk doctor lists its parts"
        )
    _warn_once(missing)
    return False


@lru_cache(maxsize=1)
def _warn_once(missing: str) -> None:
    warnings.warn(
        f"controllers, launch files, xacro and model files run without a sandbox: {missing} is "
        "missing; --sandbox require refuses this, --sandbox off hides this message",
        SandboxWarning,
        stacklevel=2,
    )


def passed_environment(sandbox: Sandbox) -> dict[str, str]:
    """Return the variables of the environment that a stranger's code gets.

    All but those of ROS where no sandbox is wanted: what the host has sourced decides nothing, and
    libraries of it are not loaded.
    """
    named = _PASSED.union(sandbox.env)
    passed = {
        name: value
        for name, value in os.environ.items()
        if name in named
        or name.startswith(OF_LIBRARIES)
        or (sandbox.mode == "off" and not name.startswith(_OF_HOST))
    }
    if _LIBRARIES in passed and _LIBRARIES not in sandbox.env:
        kept = without_ros(passed.pop(_LIBRARIES).split(os.pathsep))
        passed |= {_LIBRARIES: os.pathsep.join(kept)} if kept else {}
    return passed


def start(
    module: str,
    *arguments: str,
    sandbox: Sandbox | None,
    reads: Iterable[Path] = (),
    writes: Iterable[Path] = (),
    environment: Mapping[str, str],
    options: Sequence[str] = (),
    pass_fds: Sequence[int] = (),
    is_repeated: bool = False,
    speaks: bool = False,
    memory_bytes: int | None = None,
    **more: Any,
) -> subprocess.Popen[bytes]:
    """Start Python, isolated, with a module of ours; what it leaves running ends with it.

    `sandbox` is `None` for a module that runs nothing of a stranger's. `reads` and `writes` are
    what it may reach besides Python and the system. `more` is that of `subprocess.Popen`.
    `memory_bytes` is what it and all that it starts may hold together where the system allows it
    a control group.
    One that `speaks` gets a network of its own where the system allows it, others get none.
    A module that `is_repeated`, again and again, a server may fork where `more` is `OF_FORKED`.
    Raises SandboxError where a sandbox is required that does not work here.
    """
    paths = import_paths()
    plan: dict[str, Any] = {
        "paths": paths,
        "parent": os.getpid(),
        "readable": None,
    }
    if sandbox is not None and is_contained(sandbox):
        _compile_own()
        ours = [_PACKAGE, *_interpreter(), *(Path(name) for name in paths)]
        parts = readable_parts(ours, [*reads, *map(Path, sandbox.readable)])
        whole = [path for path, is_whole in parts.items() if is_whole]
        files = filter(os.path.isfile, (path for path in whole if path not in _SYSTEM))
        plan |= {
            "readable": whole,
            "held": sorted(files, key=_is_no_source),
            "listable": [path for path, is_whole in parts.items() if not is_whole],
            "writable": [str(write) for write in writes],
            "speaks": speaks,
            "memory_bytes": memory_bytes,
        }
    begin = partial(_popen, module, options)
    common = {**_without_python(environment), "PYTHONHASHSEED": "0"}
    if is_repeated and more == OF_FORKED:
        result = forked(
            (module, *options),
            arguments,
            plan=plan,
            environment=common,
            pass_fds=pass_fds,
            start=begin,
        )
        if result is not None:
            return result
    return begin(plan, *arguments, environment=common, pass_fds=pass_fds, **more)


def _popen(
    module: str,
    options: Sequence[str],
    plan: Mapping[str, Any],
    *arguments: str,
    environment: Mapping[str, str],
    pass_fds: Sequence[int],
    **more: Any,
) -> subprocess.Popen[bytes]:
    with tempfile.TemporaryFile() as stream:
        stream.write(json.dumps(plan).encode())
        stream.seek(0)
        return _Started(
            [sys.executable, "-s", *options, str(_START), str(stream.fileno()), module, *arguments],
            env=dict(environment),
            pass_fds=(stream.fileno(), *pass_fds),
            start_new_session=True,
            **more,
        )


def _without_python(environment: Mapping[str, str]) -> dict[str, str]:
    return {name: value for name, value in environment.items() if not name.startswith("PYTHON")}


def end(child: subprocess.Popen[bytes]) -> None:
    """End a process that `start` started, with all that descends from it."""
    if child.poll() is None:
        child.terminate()
        try:
            child.wait(_GRACE_S)
        except subprocess.TimeoutExpired:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()


def regular_within(names: Iterable[str], folders: Iterable[Path]) -> tuple[Path, ...]:
    """Return those files that a child has named which are regular and lie within the folders."""
    tops = [folder.resolve() for folder in folders]
    paths = []
    for name in names:
        with contextlib.suppress(OSError, ValueError, RuntimeError):
            path = Path(name).resolve()
            if any(path.is_relative_to(top) for top in tops) and path.is_file():
                paths.append(Path(name))
    return tuple(dict.fromkeys(paths))


def import_paths() -> list[str]:
    """Return from where the modules of this process come, but for its current folder's.

    Those of an isolated process come before them.
    """
    scripts = [Path(name).parent for name in sys.argv[:1] if name]
    # The script of a notebook's kernel lies among the packages that are installed.
    apart = [script for script in scripts if script.name not in _INSTALLED]
    left_out = {os.path.realpath(text) for text in (os.curdir, *map(str, apart))}
    own = [
        name
        for name in sys.path
        if Path(name).is_absolute() and os.path.realpath(name) not in left_out
    ]
    # What a sourced ROS has put there is for real nodes: stand-ins and our own libraries win.
    return without_ros(own)


def _interpreter() -> list[Path]:
    paths = sysconfig.get_paths()
    named = [paths[name] for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    program = Path(sys.executable)
    folders = [sys.prefix, sys.base_prefix, sys.exec_prefix, *named]
    return list(dict.fromkeys([*map(Path, folders), program.parent, program.resolve().parent]))


def _is_no_source(path: str) -> bool:
    return not path.endswith(_SOURCE_ENDINGS)


@lru_cache(maxsize=1)
def _compile_own() -> None:
    """Compile our modules: a contained process cannot keep what it compiles."""
    if any(part.endswith("-packages") for part in _PACKAGE.parts):
        return
    with contextlib.suppress(OSError):
        waiting = [str(_PACKAGE)]
        while waiting:
            folder = waiting.pop()
            with os.scandir(folder) as scandir_iterator:
                entries = list(scandir_iterator)
            folders = (entry for entry in entries if entry.is_dir(follow_symlinks=False))
            waiting += [dir_entry.path for dir_entry in folders if dir_entry.name != "__pycache__"]
            sources = [entry for entry in entries if entry.name.endswith(".py")]
            if sources and not _is_compiled(sources):
                import compileall

                compileall.compile_dir(folder, maxlevels=0, quiet=2)


def _is_compiled(sources: Sequence[os.DirEntry[str]]) -> bool:
    """Return whether the modules of one folder were compiled after the last was written."""
    written = max(source.stat().st_mtime for source in sources)
    compiled = cache_from_source(sources[0].path)
    with contextlib.suppress(FileNotFoundError):
        os.stat(compiled)  # noqa: PTH116 - a hundred folders, whose paths take as long as all else
        return os.stat(os.path.dirname(compiled)).st_mtime >= written  # noqa: PTH116, PTH120
    return False
