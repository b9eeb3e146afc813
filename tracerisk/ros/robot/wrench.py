"""The wrench topics of a robot's driver: what its wrist sensor, or its joints' torques, give.

Served is whichever topic of the type a controller subscribes to whose name is one of the
sensor's, while nobody else publishes it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.robots.sensors import Sensor

TYPE = "geometry_msgs/WrenchStamped"
HZ = 100.0
"""How often a wrench is published while somebody listens."""


class WrenchTopics(TwinNode):
    """Publishes the wrench in a wrist while a controller listens to it.

    A wrist's sensor measures weight, inertia and contacts of all that hangs on it, without a tare;
    an estimate of the joints' torques gives contacts alone.
    """

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._sensors = [
            sensor
            for sensor in runtime.twin.robot.sensors
            if sensor.kind == "wrench" or (sensor.kind == "torque" and sensor.link is not None)
        ]
        if self._sensors:
            runtime.graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change != "subscribed" or type_name != TYPE or name in self._reported:
            return
        telling = [sensor for sensor in self._sensors if sensor.reports(name)]
        if not telling or self._graph.publications(name):
            return
        self._reported.add(name)
        names = [item.name for item in telling]
        self._stream(name, TYPE, HZ, lambda: self._message(telling[0]), names)

    def _message(self, sensor: Sensor) -> Any:
        wrench = self._twin.wrench(sensor)
        if wrench is None:
            return None
        message = self._messages.new(TYPE)
        self._now(message.header)
        message.header.frame_id = sensor.link or sensor.part
        force, torque = message.wrench.force, message.wrench.torque
        force.x, force.y, force.z = wrench.force
        torque.x, torque.y, torque.z = wrench.torque
        return message
