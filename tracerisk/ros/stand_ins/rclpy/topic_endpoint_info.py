"""Who is at a topic, and how."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

from .qos import HistoryPolicy, QoSPresetProfiles, QoSProfile
from .type_hash import TypeHash


class TopicEndpointTypeEnum(IntEnum):
    """The kinds of endpoints of a topic; the numbers are those of rmw."""

    INVALID = 0
    PUBLISHER = 1
    SUBSCRIPTION = 2


@dataclass
class TopicEndpointInfo:
    """One publisher or subscription of a topic."""

    node_name: str = ""
    """The name of the node, without its namespace."""
    node_namespace: str = ""
    """The namespace of the node."""
    topic_type: str = ""
    """The type of the messages, `package/msg/Name`."""
    endpoint_type: TopicEndpointTypeEnum = TopicEndpointTypeEnum.INVALID
    """Whether it is a publisher or a subscription."""
    endpoint_gid: list[int] = field(default_factory=list)
    """The global identifier, a list of bytes."""
    qos_profile: QoSProfile = field(default_factory=lambda: QoSPresetProfiles.UNKNOWN.value)
    """The quality of service that it uses."""
    topic_type_hash: TypeHash = field(default_factory=TypeHash)
    """The hash of the type's description."""

    def __str__(self) -> str:
        profile = self.qos_profile
        depth = f" ({profile.depth})" if profile.history == HistoryPolicy.KEEP_LAST else ""
        return "\n".join(
            (
                f"Node name: {self.node_name}",
                f"Node namespace: {self.node_namespace}",
                f"Topic type: {self.topic_type}",
                f"Topic type hash: {self.topic_type_hash}",
                f"Endpoint type: {self.endpoint_type.name}",
                f"GID: {'.'.join(f'{part:02x}' for part in self.endpoint_gid)}",
                "QoS profile:",
                f"  Reliability: {profile.reliability.name}",
                f"  History (Depth): {profile.history.name}{depth}",
                f"  Durability: {profile.durability.name}",
                f"  Lifespan: {profile.lifespan}",
                f"  Deadline: {profile.deadline}",
                f"  Liveliness: {profile.liveliness.name}",
                f"  Liveliness lease duration: {profile.liveliness_lease_duration}",
            )
        )
