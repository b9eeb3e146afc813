"""Processes that talk to each other over loopback and to nobody else.

The network of a live run has no other interface: nothing can leave it, whatever the controller asks
for. Where the kernel does not allow that, there is no live run.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping

from tracerisk.common.sandbox.kernel.features import leave_network

_LOOPBACK = "127.0.0.1"
REACHES_OTHERS = (
    "the system allows the run no network of its own, and this machine has others: what the "
    "controller, a script or a launch file opens by itself could move a real robot; run it in a "
    "container without a network (docker run --network none), or where namespaces of networks are "
    "allowed: as root, or as a user where kernel.apparmor_restrict_unprivileged_userns is 0"
)
"""Why a process that shares its network with others starts no node."""
_INHERITED = ("ROS_", "RMW_", "FASTRTPS_", "CYCLONEDDS_")


def loopback_environment(environment: Mapping[str, str], master: str = "") -> dict[str, str]:
    """Return the environment of a process of a live run: inherited variables of ROS are left out.

    `master` is the address of the run's own master.
    """
    kept = {
        name: value
        for name, value in environment.items()
        if not name.startswith(_INHERITED) and not name.startswith("PYTHON")
    }
    own = {
        "ROS_HOSTNAME": _LOOPBACK,
        "ROS_IP": _LOOPBACK,
        "ROS_DISTRO": "noetic",
        "ROS_VERSION": "1",
        "PYTHONUNBUFFERED": "1",
        "TZ": "UTC",
    }
    return {**kept, **own, **({"ROS_MASTER_URI": master} if master else {})}


def command_environment(environment: Mapping[str, str], master: str) -> dict[str, str]:
    """Return the environment of a command of the user's, whose nodes speak to `master` alone.

    It is the user's own, so that packages, plugins and libraries are found as ever, but for the
    addresses.
    """
    own = {
        "ROS_MASTER_URI": master,
        "ROS_HOSTNAME": _LOOPBACK,
        "ROS_IP": _LOOPBACK,
        # Else a node that prints into a pipe shows its lines when it ends.
        "ROSCONSOLE_STDOUT_LINE_BUFFERED": "1",
        "PYTHONUNBUFFERED": "1",
    }
    return {**environment, **own}


def interfaces() -> tuple[str, ...]:
    """Return the names of the network interfaces of this process, sorted."""
    return tuple(sorted(name for _, name in socket.if_nameindex()))


def leaves_others() -> bool:
    """Leave all networks that others are on; return whether this process has loopback alone.

    To be called while the process has one thread.
    """
    return leave_network() or interfaces() == ("lo",)
