"""Processes that talk to each other over loopback and to nobody else.

Where the kernel allows it, the network of a live run has no other interface: nothing can leave it,
whatever the controller asks for. Elsewhere its addresses alone keep it on loopback.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import socket
import struct
from collections.abc import Mapping
from pathlib import Path

_CLONE_NEWUSER = 0x10000000
_CLONE_NEWNET = 0x40000000
_SIOCGIFFLAGS = 0x8913
_SIOCSIFFLAGS = 0x8914
_IFF_UP = 0x1
_LOOPBACK = "127.0.0.1"
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


def leave_network() -> bool:
    """Give this process and those it starts a network that has loopback alone; return whether.

    False where the kernel or a container does not allow it: nothing has changed then. To be called
    while the process has one thread.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    user, group = os.getuid(), os.getgid()
    if libc.unshare(_CLONE_NEWNET) != 0:
        if libc.unshare(_CLONE_NEWUSER | _CLONE_NEWNET) != 0:
            return False
        Path("/proc/self/setgroups").write_text("deny", encoding="ascii")
        Path("/proc/self/uid_map").write_text(f"{user} {user} 1", encoding="ascii")
        Path("/proc/self/gid_map").write_text(f"{group} {group} 1", encoding="ascii")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        asked = struct.pack("16sH14x", b"lo", 0)
        flags = struct.unpack_from("H", fcntl.ioctl(sock, _SIOCGIFFLAGS, asked), 16)[0]
        fcntl.ioctl(sock, _SIOCSIFFLAGS, struct.pack("16sH14x", b"lo", flags | _IFF_UP))
    return True


def interfaces() -> tuple[str, ...]:
    """Return the names of the network interfaces of this process, sorted."""
    return tuple(sorted(name for _, name in socket.if_nameindex()))
