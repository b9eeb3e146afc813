"""Bags, written and read by the package rosbags."""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Iterable, Iterator
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import genpy
from roslib.message import get_message_class

from ._records import BagMessage, CompressionTuple, TopicTuple, TypesAndTopicsTuple

if TYPE_CHECKING:
    from typing_extensions import Self

_SECOND = 1_000_000_000


class ROSBagException(Exception):
    """A bag cannot be read or written."""

    def __init__(self, value: Any = None) -> None:
        super().__init__(value)
        self.value = value


class ROSBagFormatException(ROSBagException):
    """A file is not a bag."""


class ROSBagUnindexedException(ROSBagException):
    """A bag was not closed."""


class ROSBagEncryptNotSupportedException(ROSBagException):
    """A bag cannot be encrypted."""


class ROSBagEncryptException(ROSBagException):
    """Encryption failed."""


class Compression:
    """How the parts of a bag are compressed."""

    NONE = "none"
    BZ2 = "bz2"
    LZ4 = "lz4"


_COMPRESSIONS = (Compression.NONE, Compression.BZ2, Compression.LZ4)


class Bag:
    """A bag for reading (`r`), for writing anew (`w`), or for writing more (`a`).

    It is a file, or a stream of bytes, which is closed with it.

    Raises:
        ValueError: the mode, the compression or the size of parts is none.
        OSError: the file cannot be opened.
        ROSBagFormatException: it is not a bag.
        ROSBagUnindexedException: it was not closed when it was written.
    """

    def __init__(
        self,
        f: str | os.PathLike[str] | BinaryIO,
        mode: str = "r",
        compression: str = Compression.NONE,
        chunk_threshold: int = 768 * 1024,
        allow_unindexed: bool = False,
        options: dict[str, Any] | None = None,
        skip_index: bool = False,
    ) -> None:
        if not f:
            raise ValueError("filename (or stream) is invalid")
        if mode not in ("r", "w", "a"):
            raise ValueError(f"mode {mode} is invalid")
        asked = {"compression": compression, "chunk_threshold": chunk_threshold, **(options or {})}
        if asked["compression"] not in _COMPRESSIONS:
            raise ValueError(f"compression must be one of: {', '.join(_COMPRESSIONS)}")
        if asked["chunk_threshold"] < 0:
            raise ValueError("chunk_threshold must be greater than or equal to zero")
        self.mode, self.compression = mode, asked["compression"]
        self._stream: BinaryIO | None = None
        if isinstance(f, (str, os.PathLike)):
            self.filename = os.fspath(f)
        else:
            self._stream, self.filename = f, str(getattr(f, "name", "stream"))
            self._folder = tempfile.TemporaryDirectory()
        self._path = Path(self.filename if self._stream is None else f"{self._folder.name}/bag")
        if self._stream is not None and mode != "w":
            self._path.write_bytes(self._stream.read())
        self._written: dict[str, list[int]] = {}
        self._connections: dict[tuple[str, str], Any] = {}
        self._reader: Any = None
        self._writer: Any = None
        kept: list[BagMessage] = []
        if mode == "a" and self._path.exists():
            with Bag(self._path) as before:
                kept = list(before.read_messages(raw=True))
        if mode == "r":
            self._open_reader()
        else:
            self._open_writer()
        for topic, message, at in kept:
            self.write(topic, message, at, raw=True)

    def _open_reader(self) -> None:
        from rosbags.rosbag1 import Reader, ReaderError

        reader = Reader(self._path)
        try:
            reader.open()
        except ReaderError as error:
            is_open = "index" in str(error)
            kind = ROSBagUnindexedException if is_open else ROSBagFormatException
            raise kind(f"{self.filename}: {error}") from error
        self._reader = reader

    def _open_writer(self) -> None:
        from rosbags.rosbag1 import Writer

        self._path.unlink(missing_ok=True)
        # The package refuses a file that is there, and one of this name may be elsewhere in the
        # workspace; a real bag is written anew.
        writer = Writer(self._path.with_name(f"{self._path.name}.{os.getpid()}"))
        writer.path = self._path
        if self.compression != Compression.NONE:
            writer.set_compression(Writer.CompressionFormat[self.compression.upper()])
        writer.open()
        self._writer = writer

    @property
    def size(self) -> int:
        """The size of the file [bytes].

        Raises:
            ValueError: the bag is closed.
        """
        if self._reader is None and self._writer is None:
            raise ValueError("I/O operation on closed bag")
        return self._path.stat().st_size

    def write(
        self,
        topic: str,
        msg: Any,
        t: Any = None,
        raw: bool = False,
        connection_header: dict[str, str] | None = None,
    ) -> None:
        """Write a message, at a time or now; a raw one is (type, bytes, digest, ..., class).

        Raises:
            ValueError: there is no topic or no message.
            ROSBagException: the bag is not open for writing.
        """
        if not topic:
            raise ValueError("topic is invalid")
        if not msg:
            raise ValueError("msg is invalid")
        if self._writer is None:
            raise ROSBagException(f"{self.filename} is not open for writing")
        if raw:
            name, data, kind = msg[0], msg[1], msg[-1]
        else:
            buffer = BytesIO()
            msg.serialize(buffer)
            name, data, kind = msg._type, buffer.getvalue(), type(msg)
        connection = self._connections.get((topic, name))
        if connection is None:
            connection = self._connections[topic, name] = self._writer.add_connection(
                topic, name.replace("/", "/msg/"), msgdef=kind._full_text, md5sum=kind._md5sum
            )
        at = round(time.time() * _SECOND) if t is None else t.to_nsec()
        self._writer.write(connection, at, data)
        self._written.setdefault(topic, []).append(at)

    def read_messages(
        self,
        topics: str | Iterable[str] | None = None,
        start_time: Any = None,
        end_time: Any = None,
        connection_filter: Any = None,
        raw: bool = False,
    ) -> Iterator[BagMessage]:
        """Yield the messages in the order of their times, of some topics and times only.

        `connection_filter` is called with topic, type, digest, definition and header of what was
        recorded from one publisher, and returns whether its messages are wanted.

        Raises:
            ROSBagException: the bag is not open for reading, or nobody has the class of a message.
        """
        connections = [
            item
            for item in self._of(topics)
            if connection_filter is None or connection_filter(*_described(item))
        ]
        first, last = (None if at is None else at.to_nsec() for at in (start_time, end_time))
        if not connections:
            return
        for connection, at, data in self._reader.messages(connections):
            if (first is not None and at < first) or (last is not None and at > last):
                continue
            name = connection.msgtype.replace("/msg/", "/")
            kind = get_message_class(name)
            if raw:
                message: Any = (name, bytes(data), connection.digest, 0, kind)
            elif kind is None:
                raise ROSBagException(
                    f"{self.filename}: topic {connection.topic} has messages of {name}, which is "
                    "neither in the workspace nor served"
                )
            elif kind._md5sum != connection.digest:
                raise ROSBagException(
                    f"{self.filename}: topic {connection.topic} has another {name} than the one "
                    "that is known here"
                )
            else:
                message = kind().deserialize(bytes(data))
            yield BagMessage(connection.topic, message, genpy.Time(*divmod(at, _SECOND)))

    def _of(self, topics: str | Iterable[str] | None) -> list[Any]:
        if self._reader is None:
            raise ROSBagException(f"{self.filename} is not open for reading")
        names = _names(topics)
        return [
            connection
            for connection in self._reader.connections
            if names is None or connection.topic.lstrip("/") in names
        ]

    def _times(self, topics: str | Iterable[str] | None = None) -> dict[str, list[int]]:
        """Return the times of each topic's messages [ns], in their order."""
        if self._writer is not None:
            names = _names(topics)
            return {
                topic: sorted(times)
                for topic, times in self._written.items()
                if names is None or topic.lstrip("/") in names
            }
        numbers: dict[str, list[int]] = {}
        connections = self._of(topics)
        for connection, at, _ in self._reader.messages(connections) if connections else ():
            numbers.setdefault(connection.topic, []).append(at)
        return numbers

    def get_message_count(self, topic_filters: str | Iterable[str] | None = None) -> int:
        """Return the number of messages."""
        return sum(map(len, self._times(topic_filters).values()))

    def get_start_time(self) -> float:
        """Return the time of the first message [s]; ROSBagException for none."""
        return min(self._all_times()) / _SECOND

    def get_end_time(self) -> float:
        """Return the time of the last message [s]; ROSBagException for none."""
        return max(self._all_times()) / _SECOND

    def _all_times(self) -> list[int]:
        times = [at for time in self._times().values() for at in time]
        if not times:
            raise ROSBagException("Bag contains no message")
        return times

    def get_type_and_topic_info(
        self, topic_filters: str | Iterable[str] | None = None
    ) -> TypesAndTopicsTuple:
        """Return the types with their digests, and for each topic what there is of it."""
        types = {_described(item)[1]: item.digest for item in self._of(None)}
        topics = {}
        connections = self._of(topic_filters)
        for topic, times in self._times(topic_filters).items():
            own = [connection for connection in connections if connection.topic == topic]
            name = own[0].msgtype.replace("/msg/", "/")
            periods = [late - early for early, late in pairwise(times)]
            period = statistics.median(periods) if periods else 0
            frequency = _SECOND / period if period else None
            topics[topic] = TopicTuple(name, len(times), len(own), frequency)
        return TypesAndTopicsTuple(dict(sorted(types.items())), topics)

    def get_compression_info(self) -> CompressionTuple:
        """Return how the bag is compressed, and its size before and after."""
        self._of(None)
        kinds: list[str] = []
        before = after = 0
        with self._path.open("rb") as stream:
            for info in self._reader.chunk_infos:
                stream.seek(info.pos)
                header = stream.read(int.from_bytes(stream.read(4), "little"))
                fields = _fields(header)
                kinds.append(fields[b"compression"].decode())
                before += int.from_bytes(fields[b"size"], "little")
                after += int.from_bytes(stream.read(4), "little")
        most = max(sorted(set(kinds)), key=kinds.count, default=self.compression)
        return CompressionTuple(most, before, after)

    def flush(self) -> None:
        """Do nothing: what was written is in the file when the bag is closed."""

    def close(self) -> None:
        """Finish the file."""
        for end in (self._reader, self._writer):
            if end is not None:
                end.close()
        if self._stream is not None and not self._stream.closed:
            if self._writer is not None:
                self._stream.write(self._path.read_bytes())
            self._stream.close()
            self._folder.cleanup()
        self._reader = self._writer = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __iter__(self) -> Iterator[BagMessage]:
        return self.read_messages()

    def __len__(self) -> int:
        return self.get_message_count()

    def __bool__(self) -> bool:
        return True


def _names(topics: str | Iterable[str] | None) -> set[str] | None:
    """Return the topics that are asked for, without the slash at their begin; None for all."""
    if topics is None:
        return None
    return {name.lstrip("/") for name in ([topics] if isinstance(topics, str) else topics)}


def _described(connection: Any) -> tuple[str, str, str, str, dict[str, str]]:
    """Return topic, type, digest, definition and header of a connection of a bag."""
    name = connection.msgtype.replace("/msg/", "/")
    text = connection.msgdef.data
    header = {
        "topic": connection.topic,
        "type": name,
        "md5sum": connection.digest,
        "message_definition": text,
    }
    return connection.topic, name, connection.digest, text, header


def _fields(header: bytes) -> dict[bytes, bytes]:
    """Return the fields of a record's header: `key=value`, each behind its length."""
    fields, at = {}, 0
    while at < len(header):
        end = at + 4 + int.from_bytes(header[at : at + 4], "little")
        key, _, value = header[at + 4 : end].partition(b"=")
        fields[key] = value
        at = end
    return fields
