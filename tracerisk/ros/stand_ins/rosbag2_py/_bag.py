"""Bags of ROS 2, written and read by the package rosbags."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rclpy.duration import Duration
from rclpy.time import Time
from rosidl_runtime_py.utilities import get_message

from tracerisk.ros.messages.fields import fields_of, type_of

from ._description import (
    PLUGINS,
    BagMetadata,
    ConverterOptions,
    FileInformation,
    ReadOrder,
    StorageFilter,
    StorageOptions,
    TopicInformation,
    TopicMetadata,
)


class SequentialWriter:
    """Writes messages, already serialised, into a new bag."""

    def __init__(self) -> None:
        self._writer: Any = None
        self._connections: dict[str, Any] = {}

    def open(
        self, storage_options: StorageOptions, converter_options: ConverterOptions | None = None
    ) -> None:
        """Make the bag.

        Raises:
            RuntimeError: it cannot be made there, or its storage is none that is known.
        """
        from rosbags.rosbag2 import StoragePlugin, Writer, WriterError

        _check(converter_options)
        kind = storage_options.storage_id or "mcap"
        if kind not in PLUGINS:
            raise RuntimeError(f"No storage plugin '{kind}'; there are {', '.join(PLUGINS)}")
        path = Path(storage_options.uri)
        if path.exists():
            raise RuntimeError(
                f"Bag directory already exists ({path}), can't overwrite existing bag"
            )
        try:
            writer = Writer(path, version=9, storage_plugin=StoragePlugin[kind.upper()])
            writer.open()
        except (OSError, WriterError) as error:
            raise RuntimeError(f"Failed to create bag directory ({path}): {error}") from error
        if storage_options.custom_data:
            for name, value in storage_options.custom_data.items():
                writer.set_custom_data(name, value)
        self._writer, self._connections = writer, {}

    def create_topic(self, topic_with_type: TopicMetadata) -> None:
        """Add a topic; one that is there already stays as it is.

        Raises:
            RuntimeError: the bag is not open, or nobody knows the type.
        """
        writer = self._opened()
        if topic_with_type.name in self._connections:
            return
        text, digest = _definition(topic_with_type.type)
        self._connections[topic_with_type.name] = writer.add_connection(
            topic_with_type.name, topic_with_type.type, msgdef=text, rihs01=digest
        )

    def remove_topic(self, topic_with_type: TopicMetadata) -> None:
        """Take no more messages of a topic."""
        self._connections.pop(topic_with_type.name, None)

    def write(self, topic_name: str, message: bytes, time_stamp: int, *_sent: int) -> None:
        """Write a serialised message with its time [ns].

        Raises:
            RuntimeError: the bag is not open, or the topic was not created.
        """
        writer = self._opened()
        if topic_name not in self._connections:
            raise RuntimeError(
                f"Topic '{topic_name}' has not been created yet! Call 'create_topic' first."
            )
        writer.write(self._connections[topic_name], time_stamp, bytes(message))

    def close(self) -> None:
        """Finish the bag."""
        if self._writer is not None:
            self._writer.close()
        self._writer = None

    def __del__(self) -> None:
        self.close()

    def _opened(self) -> Any:
        if self._writer is None:
            raise RuntimeError("Bag is not open. Call open() before writing.")
        return self._writer


class SequentialReader:
    """Reads the messages of a bag in the order of their times."""

    def __init__(self) -> None:
        self._reader: Any = None
        self._path = Path()
        self._filter = StorageFilter()
        self._order = ReadOrder()
        self._from_ns: int | None = None
        self._messages: Iterator[Any] | None = None
        self._next: Any = None

    def open(
        self, storage_options: StorageOptions, converter_options: ConverterOptions | None = None
    ) -> None:
        """Open a bag: its folder, or its one file.

        Raises:
            RuntimeError: there is none, or it is not one.
        """
        from rosbags.rosbag2 import Reader, ReaderError

        _check(converter_options)
        self._path = Path(storage_options.uri)
        try:
            reader = Reader(self._path)
            reader.open()
        except (OSError, ReaderError) as error:
            raise RuntimeError(f"No storage could be initialized from {self._path}: {error}") from (
                error
            )
        self._reader = reader
        self._rewind()

    def open_uri(self, uri: str) -> None:
        """Open the bag at a path; see `open`."""
        self.open(StorageOptions(uri))

    def close(self) -> None:
        """Close the bag."""
        if self._reader is not None:
            self._messages = None
            self._reader.close()
        self._reader = None

    def set_read_order(self, order: ReadOrder) -> bool:
        """Set in which order messages are read; return whether it can be."""
        self._order = order
        self._rewind()
        return True

    def set_filter(self, storage_filter: StorageFilter) -> None:
        """Read some topics only."""
        self._filter = storage_filter
        self._rewind()

    def reset_filter(self) -> None:
        """Read all topics again."""
        self.set_filter(StorageFilter())

    def seek(self, timestamp: int) -> None:
        """Go on with the first message at or after a time [ns]."""
        self._from_ns = timestamp
        self._rewind()

    def has_next(self) -> bool:
        """Return whether there is another message."""
        if self._messages is None:
            self._messages = self._read()
            self._next = next(self._messages, None)
        return self._next is not None

    def read_next(self) -> tuple[str, bytes, int]:
        """Return topic, bytes and time [ns] of the next message.

        Raises:
            RuntimeError: there is no other, or the bag is not open.
        """
        if not self.has_next():
            raise RuntimeError("Bag is at end. No next message.")
        (connection, at, data), self._next = self._next, next(self._messages or iter(()), None)
        return connection.topic, bytes(data), at

    def get_all_topics_and_types(self) -> list[TopicMetadata]:
        """Return the topics of the bag."""
        return [
            TopicMetadata(
                number, connection.topic, connection.msgtype, "cdr", [], connection.digest
            )
            for number, connection in enumerate(self._opened().connections)
        ]

    def get_metadata(self) -> BagMetadata:
        """Return what the bag holds."""
        return _metadata(self._opened(), self._path, self.get_all_topics_and_types())

    def _opened(self) -> Any:
        if self._reader is None:
            raise RuntimeError("Bag is not open. Call open() before reading.")
        return self._reader

    def _rewind(self) -> None:
        self._messages = self._next = None

    def _read(self) -> Iterator[Any]:
        reader, topics = self._opened(), self._filter.topics
        wanted = [
            connection
            for connection in reader.connections
            if not topics or connection.topic in topics
        ]
        # Without any connection, rosbags reads all.
        messages = reader.messages(wanted, start=self._from_ns) if wanted else iter(())
        return reversed(list(messages)) if self._order.reverse else iter(messages)


def _check(options: ConverterOptions | None) -> None:
    if options is None:
        return
    for format_name in (options.input_serialization_format, options.output_serialization_format):
        if format_name not in ("", "cdr"):
            raise RuntimeError(f"No serialization format '{format_name}'; there is cdr")


def _definition(type_name: str) -> tuple[str, str]:
    """Return the text of a message with those of its fields, and its digest.

    Raises:
        RuntimeError: nobody knows the type.
    """
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    try:
        message_class = get_message(type_name)
    except (ImportError, AttributeError, ValueError) as error:
        raise RuntimeError(f"package or type of '{type_name}' not found") from error
    store = get_typestore(Stores.EMPTY)
    left, known = [message_class], {}
    while left:
        each = left.pop()
        name = type_of(each).replace("/", "/msg/")
        if name in known:
            continue
        fields = fields_of(each)
        text = "\n".join(f"{field.type_text} {field.name}" for field in fields)
        known.update(get_types_from_msg(text, name))
        left += [field.message for field in fields if field.message is not None]
    store.register(known)
    return store.generate_msgdef(type_name, ros_version=2)[0], store.hash_rihs01(type_name)


def _metadata(reader: Any, path: Path, topics: list[TopicMetadata]) -> BagMetadata:
    """Return what an open bag at `path` holds."""
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    stored = [file for file in files if file.suffix in PLUGINS.values()]
    start = reader.start_time if reader.message_count else 0
    duration = reader.duration if reader.message_count else 0
    counts = {connection.topic: connection.msgcount for connection in reader.connections}
    metadata = BagMetadata(
        bag_size=sum(file.stat().st_size for file in files if file.is_file()),
        storage_identifier=next(name for name, end in PLUGINS.items() if end == stored[0].suffix),
        relative_file_paths=[file.name for file in stored],
        duration=Duration(nanoseconds=duration),
        starting_time=Time(nanoseconds=start),
        message_count=reader.message_count,
        topics_with_message_count=[TopicInformation(topic, counts[topic.name]) for topic in topics],
    )
    metadata.files = [
        FileInformation(
            file.name, metadata.starting_time, metadata.duration, metadata.message_count
        )
        for file in stored
    ]
    return metadata
