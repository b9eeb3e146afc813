"""What describes a bag: options, topics, and what is in its file."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from rclpy.duration import Duration
from rclpy.time import Time

from tracerisk.ros.imports.exported import defined as _defined

PLUGINS = {"sqlite3": ".db3", "mcap": ".mcap"}
"""The kinds of storage, each with the ending of its files."""
_TOPIC = ("name", "type", "serialization_format", "offered_qos_profiles", "type_description_hash")


@dataclass
class StorageOptions:
    """The place and the storage of a bag.

    Only `uri`, `storage_id` and `custom_data` have an effect; the other options are accepted.
    """

    uri: str
    """The path of the bag."""
    storage_id: str = ""
    """The kind of storage, a key of `PLUGINS`; empty: MCAP for a new bag."""
    max_bagfile_size: int = 0
    """The size at which a new file begins [bytes]; 0: never."""
    max_bagfile_duration: int = 0
    """The duration at which a new file begins [s]; 0: never."""
    max_cache_size: int = 0
    """The size of the write cache [bytes]; 0: none."""
    storage_preset_profile: str = ""
    """The name of a preset of the storage; empty: the default."""
    storage_config_uri: str = ""
    """The path of the storage's settings; empty: none."""
    snapshot_mode: bool = False
    """Whether messages are kept in memory until a snapshot is requested."""
    start_time_ns: int = -1
    """The begin of the part to use [ns]; -1: the begin of the bag."""
    end_time_ns: int = -1
    """The end of the part to use [ns]; -1: the end of the bag."""
    custom_data: dict[str, str] = field(default_factory=dict)
    """The entries to store in the bag's metadata, by key."""


@dataclass
class ConverterOptions:
    """The formats in which messages are serialised."""

    input_serialization_format: str = "cdr"
    """The format of the program's messages; only `cdr` is served."""
    output_serialization_format: str = "cdr"
    """The format in the bag; only `cdr` is served."""


@dataclass
class StorageFilter:
    """The choice of messages to read."""

    topics: list[str] = field(default_factory=list)
    """The names of the topics to read; empty: all."""


class ReadOrderSortBy(Enum):
    """What messages are sorted by when they are read."""

    ReceivedTimestamp = 0
    PublishedTimestamp = 1
    File = 2


@dataclass
class ReadOrder:
    """The order in which messages are read."""

    sort_by: ReadOrderSortBy = ReadOrderSortBy.ReceivedTimestamp
    """The time that messages are sorted by."""
    reverse: bool = False
    """Whether the last message comes first."""


class TopicMetadata:
    """A topic of a bag. Its number comes first since ROS 2 Jazzy; before, there was none.

    Raises:
        TypeError: an argument that it does not take, or no name or type.
    """

    def __init__(self, *arguments: Any, **named: Any) -> None:
        names = ("id", *_TOPIC) if arguments and isinstance(arguments[0], int) else _TOPIC
        given = {**dict(zip(names, arguments, strict=False)), **named}
        unknown = set(given) - {"id", *_TOPIC}
        if unknown or len(arguments) > len(names) or not {"name", "type"} <= set(given):
            raise TypeError("TopicMetadata takes id, name, type, serialization_format and more")
        self.id: int = given.get("id", 0)
        self.name: str = given["name"]
        self.type: str = given["type"]
        self.serialization_format: str = given.get("serialization_format", "cdr")
        self.offered_qos_profiles: Any = given.get("offered_qos_profiles", [])
        self.type_description_hash: str = given.get("type_description_hash", "")

    def equals(self, other: TopicMetadata) -> bool:
        """Return whether another topic is the same."""
        return all(getattr(self, name) == getattr(other, name) for name in _TOPIC[:3])

    def __repr__(self) -> str:
        return f"TopicMetadata(id={self.id}, name={self.name!r}, type={self.type!r})"


@dataclass
class TopicInformation:
    """A topic of a bag and its size."""

    topic_metadata: TopicMetadata
    """The name and type of the topic."""
    message_count: int
    """The number of its messages."""


@dataclass
class FileInformation:
    """A file of a bag."""

    path: str
    """The name of the file in the bag's folder."""
    starting_time: Time
    """The time of the first message."""
    duration: Duration
    """The time from the first to the last message."""
    message_count: int
    """The number of messages."""


@dataclass
class BagMetadata:
    """What is in a bag."""

    version: int = 9
    """The version of the metadata format."""
    bag_size: int = 0
    """The size of all files [bytes]."""
    storage_identifier: str = ""
    """The kind of storage, a key of `PLUGINS`."""
    relative_file_paths: list[str] = field(default_factory=list)
    """The names of the files in the bag's folder."""
    files: list[FileInformation] = field(default_factory=list)
    """A summary of each file."""
    duration: Duration = field(default_factory=Duration)
    """The time from the first to the last message."""
    starting_time: Time = field(default_factory=Time)
    """The time of the first message."""
    message_count: int = 0
    """The number of messages."""
    topics_with_message_count: list[TopicInformation] = field(default_factory=list)
    """A summary of each topic."""
    compression_format: str = ""
    """The format of the compression; empty: none."""
    compression_mode: str = ""
    """The unit that is compressed; empty: none."""
    custom_data: dict[str, str] = field(default_factory=dict)
    """The entries that the recorder stored, by key."""
    ros_distro: str = ""
    """The ROS distribution that recorded the bag; empty where it is not known."""


class Info:
    """Reads what is in a bag."""

    def read_metadata(self, uri: str, storage_id: str = "") -> BagMetadata:
        """Return what the bag at a path holds.

        Raises:
            RuntimeError: there is none.
        """
        from ._bag import SequentialReader

        reader = SequentialReader()
        reader.open(StorageOptions(uri, storage_id), ConverterOptions())
        try:
            return reader.get_metadata()
        finally:
            reader.close()


def get_registered_readers() -> set[str]:
    """Return the kinds of storage that can be read."""
    return set(PLUGINS)


def get_registered_writers() -> set[str]:
    """Return the kinds of storage that can be written."""
    return set(PLUGINS)


def get_registered_serializers() -> set[str]:
    """Return the formats in which messages are serialised."""
    return {"cdr"}


__all__ = _defined(globals())
