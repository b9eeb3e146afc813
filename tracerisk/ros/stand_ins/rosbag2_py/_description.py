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
    """Where a bag is and how it is stored; without `storage_id` a new one is MCAP."""

    uri: str
    storage_id: str = ""
    max_bagfile_size: int = 0
    max_bagfile_duration: int = 0
    max_cache_size: int = 0
    storage_preset_profile: str = ""
    storage_config_uri: str = ""
    snapshot_mode: bool = False
    start_time_ns: int = -1
    end_time_ns: int = -1
    custom_data: dict[str, str] = field(default_factory=dict)


@dataclass
class ConverterOptions:
    """How messages are serialised in the bag and for the program."""

    input_serialization_format: str = "cdr"
    output_serialization_format: str = "cdr"


@dataclass
class StorageFilter:
    """Which topics are read; all without one."""

    topics: list[str] = field(default_factory=list)


class ReadOrderSortBy(Enum):
    """What messages are sorted by when they are read."""

    ReceivedTimestamp = 0
    PublishedTimestamp = 1
    File = 2


@dataclass
class ReadOrder:
    """In which order messages are read."""

    sort_by: ReadOrderSortBy = ReadOrderSortBy.ReceivedTimestamp
    reverse: bool = False


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
    """A topic of a bag, and how many messages it has."""

    topic_metadata: TopicMetadata
    message_count: int


@dataclass
class FileInformation:
    """A file of a bag."""

    path: str
    starting_time: Time
    duration: Duration
    message_count: int


@dataclass
class BagMetadata:
    """What is in a bag."""

    version: int = 9
    bag_size: int = 0
    storage_identifier: str = ""
    relative_file_paths: list[str] = field(default_factory=list)
    files: list[FileInformation] = field(default_factory=list)
    duration: Duration = field(default_factory=Duration)
    starting_time: Time = field(default_factory=Time)
    message_count: int = 0
    topics_with_message_count: list[TopicInformation] = field(default_factory=list)
    compression_format: str = ""
    compression_mode: str = ""
    custom_data: dict[str, str] = field(default_factory=dict)
    ros_distro: str = ""


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
