"""Processes that talk to each other over loopback and to nobody else.

The network of a live run has no other interface: nothing can leave it, whatever the controller asks
for. Where the kernel does not allow that, there is no live run.
"""

from __future__ import annotations

import os
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
_INHERITED = ("ROS_", "RMW_", "FASTRTPS_", "FASTDDS_", "CYCLONEDDS_", "ZENOH_", "NDDS")
_MIDDLEWARE = "RMW_IMPLEMENTATION"
_OF_DDS = ("rmw_fastrtps_cpp", "rmw_fastrtps_dynamic_cpp", "rmw_cyclonedds_cpp")
"""The middlewares that need no router, and that find each other on loopback alone."""
_BY_LOCALHOST = ("foxy", "galactic", "humble")
"""The distributions that know no range of discovery; later ones warn of the older variable."""
_N_DOMAINS = 100
"""The domains from 1 on whose ports lie below those that a system gives to whoever asks."""


def domain_of_run() -> int:
    """Return the domain of ROS 2 of this process, which no other that lives on the machine has."""
    return 1 + os.getpid() % _N_DOMAINS


def domain_environment(environment: Mapping[str, str], domain: int) -> dict[str, str]:
    """Return the environment of a process of a live run on ROS 2.

    The packages of the user's are found as ever. Where other nodes are looked for is left to
    nothing that is inherited: neither addresses, nor a discovery server, nor a profile of the
    middleware.
    """
    kept = {
        name: value
        for name, value in environment.items()
        if not name.startswith(_INHERITED)
        and (not name.startswith("PYTHON") or name == "PYTHONPATH")
    }
    if environment.get(_MIDDLEWARE) in _OF_DDS:
        kept[_MIDDLEWARE] = environment[_MIDDLEWARE]
    own = {
        "ROS_VERSION": "2",
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        # A file of this kind may also lie in the folder of the run.
        "SKIP_DEFAULT_XML": "1",
        "PYTHONUNBUFFERED": "1",
        "TZ": "UTC",
    }
    distro = environment.get("ROS_DISTRO")
    if distro in _BY_LOCALHOST:
        own["ROS_LOCALHOST_ONLY"] = "1"
    return {**kept, **own, **({"ROS_DISTRO": distro} if distro else {})}


def loopback_environment(environment: Mapping[str, str], master: str = "") -> dict[str, str]:
    """Return the environment of a process of a live run on ROS 1.

    Inherited variables of ROS are left out. `master` is the address of the run's own master.
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

    Where it had another it also leaves the memory that processes share, by which nodes of ROS 2
    talk too. To be called while the process has one thread.
    """
    is_alone = interfaces() == ("lo",)
    return leave_network(also_memory=True) or is_alone
