"""What a robot of ROS 2 publishes, read by DDS without any ROS: by readers, and no writer.

A reader says to its network that it is there, as DDS does; user data it never sends. As in ROS 2,
`ROS_DOMAIN_ID` chooses the domain, and `ROS_LOCALHOST_ONLY=1` or
`ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST` holds everything on loopback.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import (
    DDSException,
    InstanceState,
    Policy,
    Qos,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from tracerisk.errors import DependencyError, InputError
from tracerisk.ros.live.link import Frame

TYPES = ("sensor_msgs/msg/JointState", "trajectory_msgs/msg/JointTrajectory")
"""What is read on whatever topic."""
TEXT = "std_msgs/msg/String"
MOST_DOMAIN = 232
"""The greatest domain whose ports exist (DDSI-RTPS 2.5, 9.6.2.3)."""
_MOST_AT_ONCE = 1000
_NEW = ViewState.Any | InstanceState.Any | SampleState.NotRead
_LOOPBACK = """
<CycloneDDS><Domain id="any">
  <General>
    <Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>
    <AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
    <Peers><Peer address="127.0.0.1"/></Peers>
  </Discovery>
</Domain></CycloneDDS>
"""
"""As ROS 2 has it for loopback alone, which has no multicast."""


def domain_of(environment: Mapping[str, str]) -> int:
    """Return the domain that the environment names.

    Raises:
        InputError: it is none.
    """
    text = environment.get("ROS_DOMAIN_ID") or "0"
    if not text.isascii() or not text.isdigit() or int(text) > MOST_DOMAIN:
        raise InputError(f"ROS_DOMAIN_ID is {text!r}; give a number from 0 to {MOST_DOMAIN}")
    return int(text)


def is_on_loopback(environment: Mapping[str, str]) -> bool:
    """Return whether the environment holds ROS 2 on loopback."""
    return (
        environment.get("ROS_LOCALHOST_ONLY") == "1"
        or environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST"
    )


class Readers:
    """Readers of the joint states and trajectories of a domain, and of text on `topics`.

    Raises:
        DependencyError: DDS cannot begin.
    """

    profile = "ros2"
    over = ""
    """Why nothing more comes; it never ends by itself."""

    def __init__(self, topics: tuple[str, ...], environment: Mapping[str, str]) -> None:
        domain = domain_of(environment)
        self._topics = topics
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._made: dict[str, Any] = {}
        self._definitions: dict[str, str] = {}
        self._readers: dict[str, tuple[Any, Any, Any]] = {}
        """The reader of each topic, its condition, and the quality that it asks for."""
        try:
            self._domain = Domain(domain, _LOOPBACK) if is_on_loopback(environment) else None
            self._participant = DomainParticipant(domain)
            self._known = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication)
            self._waiting = WaitSet(self._participant)
            self._waiting.attach(ReadCondition(self._known, _NEW))
        except DDSException as error:
            raise DependencyError(f"DDS does not begin on domain {domain}: {error}") from error

    def frames(self, seconds: float) -> list[Frame]:
        """Wait for messages, at most for some time, and return those that have come."""
        self._waiting.wait(round(seconds * 1e9))
        for item in self._known.take(_MOST_AT_ONCE):
            if item.sample_info.valid_data:
                self._heard_of(item)
        return [frame for topic in self._readers for frame in self._taken(topic)]

    def close(self) -> None:
        """Leave the domain."""
        self._readers.clear()
        del self._waiting, self._known, self._participant, self._domain

    def _heard_of(self, writer: Any) -> None:
        """Read the topic of a writer, unless it is of no interest, or read already."""
        kind, topic = _ros_type(writer.type_name), writer.topic_name.removeprefix("rt")
        if not writer.topic_name.startswith("rt/") or kind not in (*TYPES, TEXT):
            return
        if kind not in TYPES and topic not in self._topics:
            return
        # What is asked for may not be more than any writer of the topic offers.
        asked = (
            writer.qos[Policy.Reliability] != Policy.Reliability.BestEffort,
            writer.qos[Policy.Durability] == Policy.Durability.TransientLocal,
        )
        _, condition, before = self._readers.get(topic, (None, None, asked))
        asked = (asked[0] and before[0], asked[1] and before[1])
        if condition is not None:
            if asked == before:
                return
            self._waiting.detach(condition)
        quality = Qos(
            Policy.Reliability.Reliable(0) if asked[0] else Policy.Reliability.BestEffort,
            Policy.Durability.TransientLocal if asked[1] else Policy.Durability.Volatile,
            Policy.History.KeepAll,
            Policy.DataRepresentation(use_cdrv0_representation=True),
        )
        of = Topic(self._participant, writer.topic_name, self._structure(kind))
        reader: Any = DataReader(self._participant, of, quality)
        condition = ReadCondition(reader, _NEW)
        self._waiting.attach(condition)
        self._readers[topic] = reader, condition, asked

    def _taken(self, topic: str) -> list[Frame]:
        reader, _, _ = self._readers[topic]
        pairs = []
        for sample in reader.take(_MOST_AT_ONCE):
            if sample.sample_info.valid_data:
                kind = _ros_type(type(sample).__idl_typename__)
                header = {
                    "topic": topic,
                    "ns": time.time_ns(),
                    "type": kind,
                    "definition": self._definition(kind),
                }
                pairs.append((header, sample.serialize(use_version_2=False)))
        return pairs

    def _definition(self, kind: str) -> str:
        if kind not in self._definitions:
            self._definitions[kind], _ = self._store.generate_msgdef(kind, ros_version=2)
        return self._definitions[kind]

    def _structure(self, name: str) -> Any:
        """Return the class by which a message is read, named as in ROS 2's middleware."""
        if name not in self._made:
            package, kind, short = name.split("/")
            fields = {
                field: self._kind(described) for field, described in self._store.fielddefs[name][1]
            }
            self._made[name] = make_idl_struct(
                f"{short}_", f"{package}::{kind}::dds_::{short}_", fields
            )
        return self._made[name]

    def _kind(self, described: Any) -> Any:
        node, of = described
        if node == Nodetype.NAME:
            return self._structure(of)
        if node == Nodetype.BASE:
            return {"bool": bool, "string": str}.get(of[0]) or getattr(types, of[0])
        inner, length = self._kind(of[0]), of[1]
        if node == Nodetype.ARRAY:
            return types.array[inner, length]
        return types.sequence[inner, length] if length else types.sequence[inner]


def _ros_type(name: str) -> str:
    """Return `sensor_msgs/msg/JointState` for `sensor_msgs::msg::dds_::JointState_`."""
    return "/".join(part for part in name.split("::") if part != "dds_").removesuffix("_")
