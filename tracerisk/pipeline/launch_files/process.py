"""Read ROS 2 launch files in processes with limits of time and memory, which end the command."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from tracerisk.common.limits import DEFAULT_LIMITS, Limits
from tracerisk.common.sandbox.limited_process import last_words, run_limited
from tracerisk.common.sandbox.process import regular_within
from tracerisk.common.text.read_back import read_back
from tracerisk.config import controller_root
from tracerisk.errors import Location
from tracerisk.pipeline.launch_files.records import LaunchReading, RobotSource, StartedNode
from tracerisk.pipeline.workspace.prefixes import python_folders, readable_of
from tracerisk.pipeline.workspace.workspace import Workspace

_LONGEST_REASON = 200
# Launch files choose by it between what two releases name differently.
_RELEASE = {"ROS_DISTRO": "jazzy", "ROS_VERSION": "2"}


def read_launch(
    path: Path,
    workspace: Workspace,
    limits: Limits = DEFAULT_LIMITS,
    arguments: Sequence[tuple[str, str]] = (),
) -> LaunchReading:
    """Return what a ROS 2 launch file starts; what cannot be read of it is among its problems.

    `arguments` are those that its command line gives it; the others have their defaults.
    Raises LimitError where reading it takes too long or too much memory.
    """
    folders = {*workspace.import_paths, *workspace.python_packages.values()}
    asked = {
        "path": str(path.resolve()),
        "arguments": [list(argument) for argument in arguments],
        "packages": {name: str(folder) for name, folder in workspace.findable.items()},
        "import_paths": sorted(str(folder) for folder in folders),
        "installed": [str(folder) for folder in python_folders(workspace.prefixes)],
    }
    installed = readable_of(workspace.prefixes)
    around = (path.parent, controller_root(path), *workspace.packages.values(), *installed)
    done = run_limited(
        "tracerisk.pipeline.launch_files.child",
        request=json.dumps(asked).encode(),
        limits=limits,
        doing="reading the launch file",
        place=Location(str(path)),
        folder=path.parent,
        environment=_RELEASE,
        reads=(*around, *folders),
    )
    try:
        data = json.loads(done.stdout)
        return LaunchReading(
            nodes=tuple(read_back(StartedNode, item) for item in data["nodes"]),
            sources=regular_within((str(item) for item in data["sources"]), around),
            problems=tuple(str(item)[:_LONGEST_REASON] for item in data["problems"]),
            robots=tuple(read_back(RobotSource, item) for item in data["robots"]),
        )
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        reason = last_words(done)[:_LONGEST_REASON]
        return LaunchReading(problems=(f"cannot be read: {reason}",))
