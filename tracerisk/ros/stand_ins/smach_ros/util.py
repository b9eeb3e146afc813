"""Preempt state machines when the program is to end."""

from __future__ import annotations

from typing import Any

import rospy


def set_preempt_handler(sc: Any) -> None:
    """Preempt a container when the node is shut down."""
    rospy.core.add_client_shutdown_hook(sc.request_preempt)
