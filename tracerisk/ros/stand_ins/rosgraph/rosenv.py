"""What the environment says of ROS."""

from __future__ import annotations

import os
from collections.abc import Mapping

from tracerisk.ros.graph.runtime import current

ROS_MASTER_URI = "ROS_MASTER_URI"
ROS_IP = "ROS_IP"
ROS_IPV6 = "ROS_IPV6"
ROS_HOSTNAME = "ROS_HOSTNAME"
ROS_NAMESPACE = "ROS_NAMESPACE"
DEFAULT_MASTER_PORT = 11311


def get_master_uri(env: Mapping[str, str] | None = None, argv: list[str] | None = None) -> str:
    """Return where the master is, from the command line (`__master:=`), else the environment."""
    for argument in current().argv if argv is None else argv:
        if argument.startswith("__master:="):
            return argument.removeprefix("__master:=")
    text = (os.environ if env is None else env).get(ROS_MASTER_URI)
    return text or f"http://localhost:{DEFAULT_MASTER_PORT}"
