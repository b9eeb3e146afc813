"""The sensors of a robot: which there are, and in which joint or link each is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import get_args

from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.common.traced.elements import Element, SensorKind

IN_JOINTS: tuple[SensorKind, ...] = ("encoder", "torque")


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor in a joint or link."""

    kind: SensorKind
    """`encoder` or `torque` of a joint, `wrench` or `camera` at a link."""
    name: str
    """The name, unique among the robot's elements."""
    part: str
    """The name of the joint or link that it is in."""
    topics: tuple[str, ...] = ()
    """The names under which drivers publish it; a topic is one of them or stands below one, with
    any prefix."""
    link: str | None = None
    """The link in whose axes a torque sensor's estimate of a wrench is published; `None` for
    none."""

    @property
    def element(self) -> Element:
        """What a trace calls the sensor."""
        return Element(self.name, "sensor", sensor=self.kind, part=self.part)

    def reports(self, topic: str) -> bool:
        """Return whether a topic is one of the sensor's."""
        return any(f"/{name.strip('/')}/" in f"/{topic.strip('/')}/" for name in self.topics)

    def renamed(self, named: Callable[[str], str]) -> Sensor:
        """Return the sensor of a robot whose links and joints are called anew."""
        own = named(self.name) if self.kind in IN_JOINTS else self.name
        link = None if self.link is None else named(self.link)
        return replace(self, name=own, part=named(self.part), link=link)


def joint_sensor(kind: SensorKind, joint: str) -> Sensor:
    """Return the encoder or torque sensor of a joint."""
    return Sensor(kind, f"{joint}/{kind}", joint)


def read_sensors(
    top: YamlMap, arm_joints: Sequence[str], links: Sequence[str], taken: Iterable[str]
) -> tuple[tuple[Sensor, ...], tuple[str, ...]]:
    """Read what a robot file says of sensors: those that it names, the joints without an encoder.

    Names in `taken` are those of other elements. Raises RobotError with file and line.
    """
    sensors: list[Sensor] = []
    with_encoder = tuple(arm_joints)
    for entry in top.maps("sensors"):
        kind: SensorKind = entry.choice("kind", get_args(SensorKind), "kind")
        if kind == "encoder":
            entry.forbid_unknown({"kind", "joints", "source"})
            with_encoder = _joints(entry, arm_joints)
            continue
        entry.string("source")  # what a robot is said to have needs a source
        if kind == "torque":
            sensors += _torque(entry, arm_joints, links)
        else:
            entry.forbid_unknown({"kind", "name", "link", "topics", "source"})
            link = entry.choice("link", links, "link")
            topics = tuple(entry.strings("topics"))
            sensors.append(Sensor(kind, entry.string("name"), link, topics))
    seen = {*taken, *(joint_sensor("encoder", name).name for name in with_encoder)}
    for sensor in sensors:
        if sensor.name in seen:
            top.fail("sensors", f"'{sensor.name}' is defined twice, or is the name of another part")
        seen.add(sensor.name)
    return tuple(sensors), tuple(name for name in arm_joints if name not in with_encoder)


def sensors_like(
    sensors: Iterable[Sensor], joints: Iterable[str], links: Iterable[str]
) -> tuple[Sensor, ...]:
    """Return those sensors of another description of a robot whose joint or link is there."""
    known = {*joints, *links}
    return tuple(
        sensor
        if sensor.link is None or sensor.link in known
        else replace(sensor, link=None, topics=())
        for sensor in sensors
        if sensor.part in known
    )


def _torque(entry: YamlMap, arm_joints: Sequence[str], links: Sequence[str]) -> tuple[Sensor, ...]:
    entry.forbid_unknown({"kind", "joints", "link", "topics", "source"})
    topics = tuple(entry.strings("topics")) if "topics" in entry else ()
    link = entry.choice("link", links, "link") if topics or "link" in entry else None
    return tuple(
        replace(joint_sensor("torque", name), topics=topics, link=link)
        for name in _joints(entry, arm_joints)
    )


def _joints(entry: YamlMap, arm_joints: Sequence[str]) -> tuple[str, ...]:
    if entry.require("joints") == "*":
        return tuple(arm_joints)
    return entry.choices("joints", arm_joints, "joint")
