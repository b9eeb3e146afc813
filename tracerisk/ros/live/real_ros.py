"""Which Python has the real rospy, and how processes of a live run are started under it."""

from __future__ import annotations

import contextlib
import json
import select
import shutil
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from tracerisk.errors import DependencyError
from tracerisk.ros.live.link import Frame, Link

_NEEDED = ("rospy", "rosmaster", "rosgraph", "genpy")
_NOETIC = "/opt/ros/noetic/lib/python3/dist-packages"
_ASK = (
    "import importlib.util as u, json, sys; "
    f"sys.path.append({_NOETIC!r}); "
    f"missing = [n for n in {_NEEDED!r} if u.find_spec(n) is None]; "
    "print(json.dumps([list(sys.version_info[:2]), missing]))"
)
_ASK_S = 20.0
_READY_S = 30.0
_GRACE_S = 3.0


@lru_cache(maxsize=1)
def python_of_ros() -> str:
    """Return the Python that has rospy and a master.

    Raises:
        DependencyError: none has, or it is another version than that which runs tracerisk.
    """
    version = list(sys.version_info[:2])
    strange = ""
    for candidate in dict.fromkeys(("/usr/bin/python3", shutil.which("python3"), sys.executable)):
        if candidate is None or not Path(candidate).is_file():
            continue
        try:
            done = subprocess.run(
                [candidate, "-s", "-c", _ASK],
                capture_output=True,
                text=True,
                timeout=_ASK_S,
                check=True,
            )
            result, missing = json.loads(done.stdout)
        except (OSError, ValueError, subprocess.SubprocessError):
            continue
        if not missing and result == version:
            return candidate
        if not missing:
            strange = f"{candidate} has them for Python {result[0]}.{result[1]}, and "
    raise DependencyError(
        "rospy and rosmaster of ROS 1 are needed, which no Python "
        f"{version[0]}.{version[1]} here has; {strange}tracerisk runs under {sys.executable}. "
        "On Debian and Ubuntu: "
        "apt install python3-rospy python3-rosmaster python3-actionlib python3-tf2-ros "
        "python3-message-filters"
    )


def own_paths() -> list[str]:
    """Return the folders in which tracerisk and what instruments sources are found."""
    paths = [Path(__file__).resolve().parents[3]]
    for name in ("libcst", "yaml", "typing_extensions"):
        spec = find_spec(name)
        if spec is not None and spec.origin is not None:
            at = Path(spec.origin).resolve()
            paths.append(at.parents[1] if at.name == "__init__.py" else at.parent)
    return list(dict.fromkeys([*map(str, paths), _NOETIC]))


def start(
    module: str, *arguments: str, environment: Mapping[str, str], pass_fds: Sequence[int]
) -> subprocess.Popen[bytes]:
    """Start the `main` of a module of ours under the Python of ROS."""
    code = (
        "import importlib, json, sys\n"
        "paths, module = json.loads(sys.argv.pop(1))\n"
        "sys.path += paths\n"
        "importlib.import_module(module).main()\n"
    )
    what = json.dumps([own_paths(), module])
    return subprocess.Popen(
        [python_of_ros(), "-s", "-c", code, what, *arguments],
        env=dict(environment),
        pass_fds=tuple(pass_fds),
        stdin=subprocess.DEVNULL,
        close_fds=True,
    )


def start_linked(
    module: str, *, environment: Mapping[str, str], **asked: Any
) -> tuple[Link, subprocess.Popen[bytes]]:
    """Start a module of ours as `start` does; return our end of a link to it, and the process.

    Its one argument is an object in JSON: what is `asked`, and the `descriptor` of its end.
    """
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
    with theirs:
        process = start(
            module,
            json.dumps({"descriptor": theirs.fileno(), **asked}),
            environment=environment,
            pass_fds=(theirs.fileno(),),
        )
    return Link(ours), process


def first_frame(link: Link) -> Frame | None:
    """Wait for the first frame of a process that starts; None where none comes."""
    readable, _, _ = select.select([link], [], [], _READY_S)
    return link.receive() if readable else None


def end_process(process: subprocess.Popen[bytes], *signals: int) -> None:
    """Send one signal after the other, until the process has ended."""
    for signal in signals:
        if process.poll() is not None:
            return
        process.send_signal(signal)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_GRACE_S)
