"""What a bag gives of its messages and topics."""

from __future__ import annotations

from typing import Any, NamedTuple


class BagMessage(NamedTuple):
    """A recorded message."""

    topic: str
    """The name of the topic."""
    message: Any
    """The message, or the raw parts of it."""
    timestamp: Any
    """The time of the recording, a `genpy.Time`."""


class TopicTuple(NamedTuple):
    """A summary of one topic of a bag."""

    msg_type: str
    """The type of the messages, `package/Name`."""
    message_count: int
    """The number of messages."""
    connections: int
    """The number of publishers that were recorded."""
    frequency: float | None
    """The rate by the median period [Hz]; `None` for a single message."""


class TypesAndTopicsTuple(NamedTuple):
    """The types and topics of a bag."""

    msg_types: dict[str, str]
    """The MD5 sum of each type, by type."""
    topics: dict[str, TopicTuple]
    """The summary of each topic, by name."""


class CompressionTuple(NamedTuple):
    """The compression of a bag."""

    compression: str
    """The format of most chunks: `none`, `bz2` or `lz4`."""
    uncompressed: int
    """The size of all chunks before compression [bytes]."""
    compressed: int
    """The size of all chunks after compression [bytes]."""
