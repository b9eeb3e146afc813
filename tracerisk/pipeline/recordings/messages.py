"""The messages of a recording of any tool: MCAP, ROS 1 bags, and db3 of ROS 2.

Only the topics that are asked for are read, one message after another. Types come from the
definitions that the file holds; a db3 without them is read by those of ROS 2 itself.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

from tracerisk.common.dependencies import is_installed, missing_extra
from tracerisk.common.text.bounded import regular_file
from tracerisk.errors import Location, LogError, readable
from tracerisk.pipeline.recordings.recorded_topics import MAGIC

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

SUFFIXES = (".mcap", ".bag", ".db3")
"""How the names of recordings end."""
MOST_MESSAGES = 20_000_000
"""How many messages are read of a recording at most."""
MOST_BYTES = 512 * 1024**2
"""How large a record of an MCAP file may be that is read into memory [bytes]."""
_BAG, _DB3 = b"#ROSBAG V", b"SQLite format 3\x00"
_ENCODINGS = {"cdr", "ros1"}


class Message(NamedTuple):
    """One message of a recording."""

    topic: str
    """The topic on which it was received."""
    time_ns: int
    """When it was received, by the clock of the recorder [ns]."""
    value: Any
    """The deserialised message."""


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic of a recording."""

    type: str
    """As ROS 2 names it: `sensor_msgs/msg/JointState`, for ROS 1 too."""
    definition: str
    """The text that defines the type; empty where the file has none."""
    format: str
    """Of the definition: `msg` or `idl`."""
    encoding: str
    """Of the messages: `cdr` or `ros1`; what else there is cannot be read."""


@dataclass(slots=True)
class RecordingFile:
    """An open recording."""

    path: Path
    """The file, or the folder of a recording of ROS 2."""
    topics: Mapping[str, Topic]
    """The type and definition of each topic, by its name, sorted."""
    raw: Any
    """Called with topics; yields topic, time [ns] and bytes of each message, in time."""
    _stores: dict[str, Typestore] = field(default_factory=dict)
    """The message types read so far, by their definition or encoding."""

    @property
    def place(self) -> Location:
        """The file, for messages."""
        return Location(str(self.path))

    def of_type(self, *types: str) -> tuple[str, ...]:
        """Return the topics of some types that can be read, in order."""
        return tuple(
            name
            for name, topic in self.topics.items()
            if topic.type in types and topic.encoding in _ENCODINGS
        )

    def messages(self, topics: Collection[str]) -> Iterator[Message]:
        """Yield the messages of some topics, in time.

        Raises LogError where the file is damaged, or has more than can be read.
        """
        if not topics:
            return
        stores = {name: self._store(name) for name in topics}
        with _damage(self.path):
            for count, (topic, time_ns, data) in enumerate(self.raw(topics)):
                if count >= MOST_MESSAGES:
                    raise LogError(
                        f"has more than {MOST_MESSAGES} messages to be read; cut it into missions",
                        self.place,
                    )
                known, store = self.topics[topic], stores[topic]
                read = store.deserialize_cdr if known.encoding == "cdr" else store.deserialize_ros1
                yield Message(topic, time_ns, read(data, known.type))

    def _store(self, topic: str) -> Typestore:
        known = self.topics[topic]
        key = known.definition or known.encoding
        if key not in self._stores:
            with _damage(self.path):
                self._stores[key] = _typestore(known)
        return self._stores[key]


def is_recording(path: Path) -> bool:
    """Return whether a path is that of a recording: by its name, or a folder of ROS 2's."""
    return path.suffix in SUFFIXES or (path / "metadata.yaml").is_file()


@contextmanager
def open_recording(path: Path) -> Iterator[RecordingFile]:
    """Open a recording.

    Raises LogError for a file that is absent, empty, damaged or none; DependencyError where the
    extra `sim` is not installed.
    """
    place = Location(str(path))
    if not is_installed("mcap"):
        raise missing_extra("sim", "reading a recording")
    with ExitStack() as stack:
        if path.is_dir():
            if not (path / "metadata.yaml").is_file():
                raise LogError("is a folder without metadata.yaml; name a recording", place)
            yield _open_rosbags(path, stack)
            return
        with readable(path, LogError), regular_file(path) as stream:
            begin = stream.read(16)
        if not begin:
            raise LogError("is empty; was the recording ended?", place)
        if begin.startswith(MAGIC):
            yield _open_mcap(path, stack)
        elif begin.startswith((_BAG, _DB3)):
            yield _open_rosbags(path, stack)
        else:
            raise LogError(
                "is not a recording; give an MCAP file, a bag of ROS 1 or a db3 of ROS 2", place
            )


def _open_mcap(path: Path, stack: ExitStack) -> RecordingFile:
    from mcap.reader import NonSeekingReader, SeekingReader

    with _damage(path):
        stream: IO[bytes] = stack.enter_context(regular_file(path))
        reader = SeekingReader(stream, record_size_limit=MOST_BYTES)
        summary = reader.get_summary()
        if summary is None:
            raise LogError(
                "has no summary, and was cut short; run `mcap recover` on it", Location(str(path))
            )
        topics: dict[str, Topic] = {}
        for channel in summary.channels.values():
            schema = summary.schemas.get(channel.schema_id)
            if schema is None:
                topics[channel.topic] = Topic("", "", "", "")
                continue
            topics[channel.topic] = Topic(
                _ros2_name(schema.name),
                schema.data.decode("utf-8", "replace"),
                "idl" if schema.encoding == "ros2idl" else "msg",
                channel.message_encoding if schema.encoding.startswith("ros") else "",
            )

    def raw(wanted: Collection[str]) -> Iterator[tuple[str, int, bytes]]:
        # A file without indexes is read from its begin to its end.
        indexed = bool(summary.chunk_indexes) or not summary.statistics
        kind = SeekingReader if indexed else NonSeekingReader
        stream.seek(0)
        for _, channel, message in kind(stream, record_size_limit=MOST_BYTES).iter_messages(
            topics=list(wanted)
        ):
            yield channel.topic, message.log_time, message.data

    return RecordingFile(path, dict(sorted(topics.items())), raw)


def _open_rosbags(path: Path, stack: ExitStack) -> RecordingFile:
    from rosbags.interfaces import MessageDefinitionFormat
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2

    is_bag = path.is_file() and path.suffix != ".db3"
    with _damage(path):
        for item in [path] if path.is_file() else sorted(path.glob("*.db3")):
            _check_pages(item)
        reader: Any = stack.enter_context(Reader1(path) if is_bag else Reader2(path))
    topics: dict[str, Topic] = {}
    for item in reader.connections:
        form = item.msgdef.format
        topics[item.topic] = Topic(
            _ros2_name(item.msgtype),
            "" if form == MessageDefinitionFormat.NONE else item.msgdef.data,
            "idl" if form == MessageDefinitionFormat.IDL else "msg",
            "ros1" if is_bag else "cdr",
        )

    def raw(wanted: Collection[str]) -> Iterator[tuple[str, int, bytes]]:
        connections = [item for item in reader.connections if item.topic in wanted]
        for connection, time_ns, data in reader.messages(connections):
            yield connection.topic, time_ns, data

    return RecordingFile(path, dict(sorted(topics.items())), raw)


def _check_pages(path: Path) -> None:
    """Raise EOFError for a database that lacks pages, which SQLite finds only where it reads them.

    Source: https://sqlite.org/fileformat.html, offsets 16 and 28.
    """
    with regular_file(path) as stream:
        head = stream.read(32)
    if head.startswith(_DB3):
        size, pages = int.from_bytes(head[16:18], "big"), int.from_bytes(head[28:32], "big")
        if path.stat().st_size < (65536 if size == 1 else size) * pages:
            raise EOFError("pages are missing")


def _typestore(topic: Topic) -> Typestore:
    from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

    if not topic.definition:
        return get_typestore(Stores.ROS2_JAZZY)
    store = get_typestore(Stores.EMPTY)
    if topic.format == "msg":
        store.register(get_types_from_msg(topic.definition, topic.type))
        return store
    line = "=" * 80 + "\n"
    for part in topic.definition.split(line):
        text = part.partition("\n")[2] if part.startswith("IDL: ") else part
        if text.strip():
            store.register(get_types_from_idl(text))
    return store


def _ros2_name(name: str) -> str:
    package, _, rest = name.partition("/")
    return name if "/" in rest or not rest else f"{package}/msg/{rest}"


@contextmanager
def _damage(path: Path) -> Iterator[None]:
    """Turn what readers raise at damaged files into LogError."""
    # What rosbags and mcap read SQLite and compressed chunks with.
    from apsw import Error as SqliteError
    from mcap.exceptions import McapError
    from rosbags.highlevel import AnyReaderError
    from rosbags.rosbag1 import ReaderError as Error1
    from rosbags.rosbag2 import ReaderError as Error2
    from rosbags.serde import SerdeError
    from rosbags.typesys import TypesysError
    from zstandard import ZstdError

    try:
        yield
    except LogError:
        raise
    except (
        *(McapError, AnyReaderError, Error1, Error2, SerdeError, TypesysError),
        *(struct.error, ArithmeticError, AssertionError, EOFError, LookupError, OSError),
        *(RecursionError, RuntimeError, StopIteration, TypeError, ValueError, AttributeError),
        *(MemoryError, SqliteError, ZstdError),
    ) as error:
        message = f"{type(error).__name__}: {str(error)[:200]}".rstrip(": ")
        raise LogError(
            f"is damaged or was cut short ({message}); `rosbag reindex`, `ros2 bag reindex` or "
            "`mcap recover` may save what it holds",
            Location(str(path)),
        ) from error
