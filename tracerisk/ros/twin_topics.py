"""What the twin publishes of itself, as the drivers of a real robot do: `/joint_states`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tracerisk.ros.graph import Change, Publication
from tracerisk.ros.message_base import Message
from tracerisk.ros.messages import Interfaces
from tracerisk.ros.messages2 import Interfaces2, Message2
from tracerisk.ros.rostime import Time
from tracerisk.ros.runtime import Runtime
from tracerisk.ros.virtual_clock import EPOCH_NS

JOINT_STATES = "/joint_states"
JOINT_STATE_TYPE = "sensor_msgs/JointState"
RATE_HZ = 50.0
"""How often joint states are published while somebody listens; a usual rate of drivers."""

_PUBLISHER = "/joint_state_publisher"


class TwinTopics:
    """Publishes the state of the twin's joints while anybody subscribes to it.

    `interfaces` makes the classes that the controller receives. What is published keeps no run
    going: a controller that only listens still comes to its end.
    """

    def __init__(self, runtime: Runtime, interfaces: Interfaces | Interfaces2) -> None:
        self._runtime = runtime
        self._message: Callable[[], type[Message | Message2]] = lambda: interfaces.message(
            JOINT_STATE_TYPE
        )
        self._publication: Publication = runtime.graph.advertise(
            JOINT_STATES, JOINT_STATE_TYPE, node=_PUBLISHER
        )
        self._sequence = 0
        self._is_ticking = False
        runtime.graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:  # noqa: ARG002
        if change == "subscribed" and name == JOINT_STATES and not self._is_ticking:
            self._is_ticking = True
            self._schedule()

    def _schedule(self) -> None:
        scheduler = self._runtime.scheduler
        period_ns = round(1e9 / RATE_HZ)
        following_ns = (scheduler.now_ns // period_ns + 1) * period_ns
        scheduler.call_at(following_ns, self._tick, background=True)

    def _tick(self) -> None:
        if not self._publication.subscriptions:
            self._is_ticking = False
            return
        self._publication.publish(self._joint_state())
        self._schedule()

    def _joint_state(self) -> Any:
        state = self._runtime.twin.joint_state()
        message: Any = self._message()()
        self._sequence += 1
        stamp = Time(0, EPOCH_NS + self._runtime.scheduler.now_ns)
        if isinstance(message, Message2):
            header: Any = message.header  # type: ignore[attr-defined]
            header.stamp.sec, header.stamp.nanosec = stamp.secs, stamp.nsecs
        else:
            message.header.seq = self._sequence
            message.header.stamp = stamp
        message.name = list(state.names)
        message.position = list(state.position)
        message.velocity = list(state.velocity)
        message.effort = list(state.effort)
        return message
