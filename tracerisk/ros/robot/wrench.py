"""The wrench topics of a robot's driver: what its wrist sensor, or its joints' torques, give.

Served is whichever topic of the type a controller subscribes to whose name is one of the
sensor's, while nobody else publishes it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.state_topics import TopicStream

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.robots.sensors import Sensor

TYPE = "geometry_msgs/WrenchStamped"
HZ = 100.0
"""How often a wrench is published while somebody listens."""

_NODE = "/robot_driver"


class WrenchTopics:
    """Publishes the wrench in a wrist while a controller listens to it.

    A wrist's sensor measures weight, inertia and contacts of all that hangs on it, without a tare;
    an estimate of the joints' torques gives contacts alone.
    """

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        self._runtime = runtime
        self._messages = messages
        self._sensors = [
            each
            for each in runtime.twin.robot.sensors
            if each.kind == "wrench" or (each.kind == "torque" and each.link is not None)
        ]
        self._served: set[str] = set()
        if self._sensors:
            runtime.graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change != "subscribed" or type_name != TYPE or name in self._served:
            return
        graph = self._runtime.graph
        telling = [each for each in self._sensors if each.reports(name)]
        if not telling or graph.publications(name):
            return
        self._served.add(name)
        publication = graph.advertise(name, TYPE, node=_NODE)
        reading = self._runtime.client(SensorReading)
        reading.reports(publication, [each.name for each in telling], HZ)
        TopicStream(self._runtime, publication, HZ, lambda: self._message(telling[0]))

    def _message(self, sensor: Sensor) -> Any:
        wrench = self._runtime.twin.wrench(sensor)
        if wrench is None:
            return None
        message = self._messages.new(TYPE)
        self._messages.stamp(message.header, self._runtime.scheduler.now_ns)
        message.header.frame_id = sensor.link or sensor.part
        force, torque = message.wrench.force, message.wrench.torque
        force.x, force.y, force.z = wrench.force
        torque.x, torque.y, torque.z = wrench.torque
        return message
