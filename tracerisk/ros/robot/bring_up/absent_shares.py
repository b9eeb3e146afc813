"""Share folders of makers' description packages that are not here.

Such a package is installed on the robot's computer. A program that asks for its folder to put the
path of a file together goes on, for the robot of the package is simulated already.
"""

from __future__ import annotations

from pathlib import Path

from tracerisk.ros.graph.runtime import Runtime
from tracerisk.twin.workspace.absent_macros import ARMS

_SHARE = Path("/absent/share")
"""Where packages that are not here are said to be, by their names."""


def absent_share(package: str, runtime: Runtime) -> Path | None:
    """Return where a maker's description package would be, with a finding; `None` for others."""
    if package not in ARMS:
        return None
    folder = _SHARE / package
    runtime.recorder.finding(
        "answer_assumed",
        f"package '{package}' is not here, and {runtime.twin.robot.name} is simulated: its folder "
        f"is given as {folder}, which holds no file",
        object_name=package,
    )
    return folder
