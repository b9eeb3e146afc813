"""Which Python has the real rospy or rclpy, and how processes of a live run start under it."""

from __future__ import annotations

import contextlib
import json
import os
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
from tracerisk.instrument.source.ros_version import RosVersion
from tracerisk.ros.live.link import Frame, Link

PYTHON_OF_RCLPY = "RCLPY_PYTHON"
"""The variable that names the Python which has rclpy, where it is not that of the PATH."""
_NEEDED: dict[RosVersion, tuple[str, ...]] = {
    1: ("rospy", "rosmaster", "rosgraph", "genpy"),
    2: ("rclpy._rclpy_pybind11", "rosgraph_msgs.msg", "action_msgs.msg"),
}
_NOETIC = "/opt/ros/noetic/lib/python3/dist-packages"
_ASK = (
    "import importlib, json, sys\n"
    "needed, more = json.loads(sys.argv[1])\n"
    "sys.path += more\n"
    "missing = []\n"
    "for name in needed:\n"
    "    try:\n"
    "        importlib.import_module(name)\n"
    "    except ImportError:\n"
    "        missing.append(name)\n"
    "print(json.dumps([list(sys.version_info[:2]), missing]))\n"
)
_REMEDIES: dict[RosVersion, tuple[str, str]] = {
    1: (
        "rospy and rosmaster of ROS 1 are",
        "On Debian and Ubuntu: apt install python3-rospy python3-rosmaster python3-actionlib "
        "python3-tf2-ros python3-message-filters",
    ),
    2: (
        "rclpy of ROS 2 with its messages is",
        "Source the setup of ROS first (. /opt/ros/jazzy/setup.bash) and install tracerisk under "
        f"its Python, or name a Python that has rclpy by {PYTHON_OF_RCLPY}",
    ),
}
"""What is needed of each version, and how to get it."""
_ASK_S = 120.0
"""How long a Python may take to import what is needed, also on a busy machine."""
_READY_S = 120.0
_GRACE_S = 3.0


@lru_cache(maxsize=2)
def python_of_ros(ros: RosVersion = 1) -> str:
    """Return the Python that has rospy and a master, or rclpy.

    Raises:
        DependencyError: none has, or it is another version than that which runs tracerisk.
    """
    version = list(sys.version_info[:2])
    strange: list[str] = []
    named = [os.environ.get(PYTHON_OF_RCLPY), shutil.which("python3")] if ros == 2 else []
    candidates = (*named, "/usr/bin/python3", shutil.which("python3"), sys.executable)
    for candidate in dict.fromkeys(candidates):
        if not candidate or not Path(candidate).is_file():
            continue
        asked = json.dumps([_NEEDED[ros], more_paths(ros)])
        try:
            done = subprocess.run(
                [candidate, "-s", "-c", _ASK, asked],
                capture_output=True,
                text=True,
                timeout=_ASK_S,
                check=True,
            )
            result, missing = json.loads(done.stdout)
        except subprocess.TimeoutExpired:
            strange.append(f"{candidate} did not answer in {_ASK_S:g} s, and ")
            continue
        except (OSError, ValueError, subprocess.SubprocessError):
            continue
        if not missing and result == version:
            return candidate
        if not missing:
            strange.append(f"{candidate} has them for Python {result[0]}.{result[1]}, and ")
    what, remedy = _REMEDIES[ros]
    raise DependencyError(
        f"{what} needed, which no Python {version[0]}.{version[1]} here has; {''.join(strange)}"
        f"tracerisk runs under {sys.executable}. {remedy}"
    )


def more_paths(ros: RosVersion) -> list[str]:
    """Return the folders in which an installed ROS is found that nobody has sourced."""
    return [_NOETIC] if ros == 1 else []


def own_paths(ros: RosVersion) -> list[str]:
    """Return the folders in which tracerisk and what instruments sources are found."""
    paths = [Path(__file__).resolve().parents[3]]
    for name in ("libcst", "yaml", "typing_extensions"):
        spec = find_spec(name)
        if spec is not None and spec.origin is not None:
            at = Path(spec.origin).resolve()
            paths.append(at.parents[1] if at.name == "__init__.py" else at.parent)
    return list(dict.fromkeys([*map(str, paths), *more_paths(ros)]))


def start(
    module: str,
    *arguments: str,
    environment: Mapping[str, str],
    pass_fds: Sequence[int],
    ros: RosVersion = 1,
) -> subprocess.Popen[bytes]:
    """Start the `main` of a module of ours under the Python of ROS."""
    code = (
        "import importlib, json, sys\n"
        "paths, module = json.loads(sys.argv.pop(1))\n"
        "sys.path += paths\n"
        "importlib.import_module(module).main()\n"
    )
    what = json.dumps([own_paths(ros), module])
    return subprocess.Popen(
        [python_of_ros(ros), "-s", "-c", code, what, *arguments],
        env=dict(environment),
        pass_fds=tuple(pass_fds),
        stdin=subprocess.DEVNULL,
        close_fds=True,
    )


def start_linked(
    module: str, *, environment: Mapping[str, str], ros: RosVersion = 1, **asked: Any
) -> tuple[Link, subprocess.Popen[bytes]]:
    """Start a module of ours as `start` does; return our end of a link to it, and the process.

    Its one argument is an object in JSON: what is `asked`, the version of ROS, and the
    `descriptor` of its end.
    """
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
    with theirs:
        process = start(
            module,
            json.dumps({"descriptor": theirs.fileno(), "ros": ros, **asked}),
            environment=environment,
            pass_fds=(theirs.fileno(),),
            ros=ros,
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
