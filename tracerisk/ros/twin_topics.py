"""What the twin publishes of itself, as the drivers of a real robot do: joint states, the clock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from tracerisk.ros.graph import Change, Publication
from tracerisk.ros.message_dialect import set_time
from tracerisk.ros.messages import Interfaces
from tracerisk.ros.messages2 import Interfaces2, Message2
from tracerisk.ros.runtime import Runtime
from tracerisk.ros.sensor_reading import JOINT_STATES_HZ, SensorReading
from tracerisk.ros.virtual_clock import EPOCH_NS

JOINT_STATES = "/joint_states"
JOINT_STATE_TYPE = "sensor_msgs/JointState"

CLOCK = "/clock"
CLOCK_TYPE = "rosgraph_msgs/Clock"
CLOCK_HZ = 100.0
"""How often the simulated time is published while somebody listens."""

_PUBLISHER = "/joint_state_publisher"
_CLOCK_PUBLISHER = "/clock_publisher"


class TwinTopics:
    """Publishes the twin's joint states, and the clock, while anybody subscribes to them.

    `interfaces` makes the classes that the controller receives. `rate_hz` is how often joint
    states come, `order` the joints in the order in which a driver tells them: first these, then
    the others in the robot's own. What is published keeps no run going: a controller that only
    listens still comes to its end.
    """

    def __init__(
        self,
        runtime: Runtime,
        interfaces: Interfaces | Interfaces2,
        *,
        rate_hz: float = JOINT_STATES_HZ,
        order: Sequence[str] = (),
    ) -> None:
        self._runtime = runtime
        self._interfaces = interfaces
        self._order = tuple(order)
        self._sequence = 0
        advertise = runtime.graph.advertise
        joints = advertise(JOINT_STATES, JOINT_STATE_TYPE, node=_PUBLISHER)
        runtime.client(SensorReading).tells_joints(joints, rate_hz)
        TopicStream(runtime, joints, rate_hz, self._joint_state)
        clock = advertise(CLOCK, CLOCK_TYPE, node=_CLOCK_PUBLISHER)
        TopicStream(runtime, clock, CLOCK_HZ, self._clock)

    def _joint_state(self) -> Any:
        state = self._runtime.twin.joint_state()
        message: Any = self._interfaces.message(JOINT_STATE_TYPE)()
        self._sequence += 1
        if not isinstance(message, Message2):
            message.header.seq = self._sequence
        set_time(message.header.stamp, EPOCH_NS + self._runtime.scheduler.now_ns)
        first = [state.names.index(name) for name in self._order if name in state.names]
        places = [*first, *(i for i in range(len(state.names)) if i not in first)]
        message.name = [state.names[i] for i in places]
        message.position = [state.position[i] for i in places]
        message.velocity = [state.velocity[i] for i in places]
        message.effort = [state.effort[i] for i in places]
        return message

    def _clock(self) -> Any:
        message: Any = self._interfaces.message(CLOCK_TYPE)()
        set_time(message.clock, EPOCH_NS + self._runtime.scheduler.now_ns)
        return message


class TopicStream:
    """Publishes what `make` makes, `hz` times a second, while the topic has a subscription."""

    def __init__(
        self, runtime: Runtime, publication: Publication, hz: float, make: Callable[[], Any]
    ) -> None:
        self._scheduler = runtime.scheduler
        self._publication = publication
        self._period_ns = round(1e9 / hz)
        self._make = make
        self._is_ticking = False
        runtime.graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        del type_name
        if change == "subscribed" and name == self._publication.topic and not self._is_ticking:
            self._is_ticking = True
            self._schedule()

    def _schedule(self) -> None:
        following_ns = (self._scheduler.now_ns // self._period_ns + 1) * self._period_ns
        self._scheduler.call_at(following_ns, self._tick, background=True)

    def _tick(self) -> None:
        if not self._publication.subscriptions:
            self._is_ticking = False
            return
        self._publication.publish(self._make())
        self._schedule()
