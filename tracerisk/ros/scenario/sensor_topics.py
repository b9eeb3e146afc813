"""Which sensors the topics of a scenario stand for: the robot's own, or others in its world."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tracerisk.common.traced.elements import Element, SensorKind

if TYPE_CHECKING:
    from tracerisk.ros.scenario.scenario import Published, Scenario
    from tracerisk.twin.robots.robot import Robot

CAMERA_TYPES = frozenset(
    f"sensor_msgs/{name}" for name in ("Image", "CompressedImage", "PointCloud2", "CameraInfo")
)
WRENCH_TYPES = frozenset({"geometry_msgs/WrenchStamped"})
_TRANSPORTS = ("compressed", "compressedDepth", "theora")


def reporting_sensors(robot: Robot, published: Published) -> tuple[str, ...]:
    """Return the names of the sensors that an entry of a scenario publishes; empty for none.

    They are those of the robot whose topic it is, else one that is named by the topic.
    """
    kinds = _kinds(published.type_name)
    own = tuple(
        sensor.name
        for sensor in robot.sensors
        if sensor.kind in kinds and sensor.reports(published.topic)
    )
    if own or not kinds:
        return own
    return (_sensor_name(published),)


def scenario_elements(robot: Robot, scenario: Scenario) -> tuple[Element, ...]:
    """Return the sensors of a scenario that are none of the robot's own, by their names."""
    own = {element.name for element in robot.elements}
    elements = {
        name: Element(name, "sensor", sensor=_kinds(published.type_name)[0])
        for published in scenario.published
        for name in reporting_sensors(robot, published)
        if name not in own
    }
    return tuple(elements[name] for name in sorted(elements))


def _kinds(type_name: str) -> Sequence[SensorKind]:
    if type_name in CAMERA_TYPES:
        return ("camera",)
    return ("wrench", "torque") if type_name in WRENCH_TYPES else ()


def _sensor_name(published: Published) -> str:
    """Return the topic without what distinguishes the topics of one sensor.

    Images, their calibration and the points seen in them stand side by side below a camera's name.
    """
    parts = published.topic.strip("/").split("/")
    if published.type_name in WRENCH_TYPES:
        return "/".join(parts)
    if len(parts) > 1 and parts[-1] in _TRANSPORTS:
        parts.pop()
    return "/".join(parts[:-1] or parts)
