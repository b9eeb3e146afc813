"""The command that starts compiled nodes: what may stand there, and what else it has to say."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from tracerisk.errors import DependencyError, InputError, Location
from tracerisk.instrument.source.ros_version import RosVersion

_LAUNCH: dict[RosVersion, tuple[str, ...]] = {
    1: (".launch", ".launch.xml"),
    2: (".launch.py", ".launch.xml", ".launch.yaml"),
}
_LAUNCHED_BY: dict[RosVersion, tuple[str, ...]] = {1: ("roslaunch",), 2: ("ros2", "launch")}
LAUNCHERS = frozenset(words[0] for words in _LAUNCHED_BY.values())
"""The programs that start nodes, and only wait from then on."""
_FROM: dict[str, str] = {
    "roslaunch": "source setup.bash of ROS, or on Debian and Ubuntu: apt install python3-roslaunch",
    "ros2": "source setup.bash of ROS",
}
"""Where the programs that start nodes come from."""
_OWN_ADDRESS = re.compile(r"__(?:master|ip|hostname):=")


def command_words(given: Sequence[str], ros: RosVersion) -> tuple[str, ...]:
    """Return the program and arguments of a command; what ROS launches, its own program starts."""
    if given[0].endswith(_LAUNCH[ros]) and Path(given[0]).is_file():
        return (*_LAUNCHED_BY[ros], *given)
    return tuple(given)


def check_command(
    given: Sequence[str], controller: str, environment: Mapping[str, str], ros: RosVersion
) -> None:
    """Refuse what starts no node of a run.

    `controller` is the C or C++ source that it belongs to, as messages call it.

    Raises:
        InputError: there is no command, or no program of its name, or it names a master.
        DependencyError: it needs a program of ROS, which is not there.
    """
    if not given:
        by = " ".join(_LAUNCHED_BY[ros])
        runs = "rosrun" if ros == 1 else "ros2 run"
        raise InputError(
            "is C or C++, whose node is started by a command: "
            f"`tracerisk run {controller} --live -- COMMAND`, where COMMAND is its executable, "
            f"`{runs} PACKAGE NODE`, `{by} PACKAGE FILE` or a launch file",
            Location(controller),
        )
    for word in given:
        if _OWN_ADDRESS.match(word):
            raise InputError(
                f"{word} names where a node finds others; leave it out: a live run has its own "
                "master on loopback"
            )
    program = command_words(given, ros)[0]
    if shutil.which(program, path=environment.get("PATH")) is not None:
        return
    if program in _FROM:
        raise DependencyError(
            f"{program}, which starts launch files, is not in PATH; {_FROM[program]}"
        )
    there = "is there and cannot be executed" if Path(program).exists() else "is not there"
    raise InputError(
        f"the program {program} of the command {there}; build it, source setup.bash of its "
        "workspace, or give its path"
    )
