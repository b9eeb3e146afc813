"""Waiting for one message."""

from __future__ import annotations

from typing import Any

from tracerisk.ros.controller.needs import Need

from ._run import run
from .node import Node
from .qos import QoSProfile


def wait_for_message(
    msg_type: Any,
    node: Node,
    topic: str,
    *,
    qos_profile: QoSProfile | int = 1,
    time_to_wait: float = -1,
) -> tuple[bool, Any]:
    """Wait for a message of a topic, for ever where `time_to_wait` [s] is negative.

    Return whether one came, and the message; nothing has to spin.
    """
    received: list[Any] = []
    subscription = node.create_subscription(msg_type, topic, received.append, qos_profile)
    try:
        run().scheduler.wait_until(
            lambda: bool(subscription._queue) or not node.context.is_valid,
            timeout_ns=None if time_to_wait < 0 else round(time_to_wait * 1e9),
            reason=f"a message on {subscription.topic_name} ({msg_type._ros_type})",
            kind="unmet",
            need=Need("topic", subscription.topic_name, msg_type._ros_type),
        )
        if not subscription._queue:
            return False, None
        return True, subscription._queue.popleft()[0]
    finally:
        node.destroy_subscription(subscription)
