"""Stand-in for rosgraph: the master, names, and the environment of ROS 1."""

from __future__ import annotations

from .masterapi import Error as MasterError
from .masterapi import Failure as MasterFailure
from .masterapi import Master, MasterException, is_online
from .names import myargv
from .rosenv import ROS_HOSTNAME, ROS_IP, ROS_IPV6, ROS_MASTER_URI, ROS_NAMESPACE, get_master_uri

__all__ = [
    "ROS_HOSTNAME",
    "ROS_IP",
    "ROS_IPV6",
    "ROS_MASTER_URI",
    "ROS_NAMESPACE",
    "Master",
    "MasterError",
    "MasterException",
    "MasterFailure",
    "get_master_uri",
    "is_master_online",
    "myargv",
]


def is_master_online(master_uri: str | None = None) -> bool:
    """Return whether a master answers: that of the run, on this machine, and no other."""
    return is_online(master_uri)
