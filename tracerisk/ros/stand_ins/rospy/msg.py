"""Messages as arguments: any type, and how a call's arguments become a message."""

from __future__ import annotations

import struct
from io import BytesIO
from typing import Any

from tracerisk.ros.graph.graph_names import ANY_TYPE
from tracerisk.ros.messages.ros1_base import DeserializationError, Message

from .exceptions import ROSException

_LENGTH = struct.Struct("<I")


class AnyMsg(Message):
    """A message of any type, as the bytes that came: `_buff`."""

    __slots__ = ["_buff"]

    _md5sum = ANY_TYPE
    _type = ANY_TYPE
    _has_header = False
    _full_text = ""

    def __init__(self, *args: Any) -> None:
        if args:
            raise ROSException("AnyMsg does not accept arguments")
        self._buff: bytes | None = None

    def serialize(self, buff: Any) -> None:
        """Write the bytes as they came.

        Raises:
            ROSException: none came.
        """
        if self._buff is None:
            raise ROSException("AnyMsg is not initialized")
        buff.write(self._buff)

    def deserialize(self, str: bytes) -> AnyMsg:
        """Keep the bytes."""
        self._buff = str
        return self


def args_kwds_to_message(data_class: Any, args: tuple[Any, ...], kwds: dict[str, Any]) -> Any:
    """Return the message that a call's arguments stand for: one message, its fields, or names.

    Raises:
        TypeError: positional arguments and keywords, or a message of another type.
    """
    if args and kwds:
        raise TypeError("publish() can be called with arguments or keywords, but not both.")
    if kwds:
        return data_class(**kwds)
    if len(args) == 1 and isinstance(args[0], Message):
        given = args[0]
        if isinstance(given, AnyMsg) or given._type == data_class._type:
            return given
        if not data_class._slot_types:
            raise TypeError(f"expected [] but got [{given._type}]")
        if given._type != data_class._slot_types[0]:
            raise TypeError(f"expected [{data_class._slot_types[0]}] but got [{given._type}]")
    return data_class(*args)


def to_bytes(message: Message) -> bytes:
    """Return a message as it goes over the wire.

    Raises:
        SerializationError: a field holds what its type cannot take.
    """
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def sent_copy(message: Message, data_class: Any) -> Any:
    """Return a message as `data_class` receives it: through the wire's format."""
    return data_class().deserialize(to_bytes(message))


def serialize_message(b: BytesIO, seq: int, msg: Message) -> None:
    """Write a message as it goes over a connection: its length, then itself.

    A header of the message gets the number `seq`, and "0" for a frame that is None.

    Raises:
        SerializationError: a field holds what its type cannot take.
    """
    header: Any = getattr(msg, "header", None) if type(msg)._has_header else None
    if header is not None:
        header.seq = seq
        if header.frame_id is None:
            header.frame_id = "0"
    body = to_bytes(msg)
    b.write(_LENGTH.pack(len(body)) + body)


def deserialize_messages(
    b: BytesIO,
    msg_queue: list[Any],
    data_class: Any,
    queue_size: int | None = None,
    max_msgs: int | None = None,
    start: int = 0,
) -> None:
    """Read the whole messages between `start` and the position of `b`, and remove them from it.

    Of all in the queue the last `queue_size` are kept; `max_msgs` is how many are read at most.

    Raises:
        DeserializationError: what stands there are no such messages.
    """
    try:
        data = b.getvalue()[start : b.tell()]
        at = 0
        bodies: list[bytes] = []
        while len(data) - at >= _LENGTH.size and not (max_msgs and len(bodies) >= max_msgs):
            begin = at + _LENGTH.size
            end = begin + _LENGTH.unpack_from(data, at)[0]
            if end > len(data):
                break
            bodies.append(data[begin:end])
            at = end
        kept = bodies if queue_size is None else bodies[-queue_size:]
        msg_queue += [data_class().deserialize(chunk) for chunk in kept]
        if queue_size is not None:
            del msg_queue[:-queue_size]
        if at:
            b.seek(start)
            b.truncate()
            b.write(data[at:])
    except Exception as error:
        raise DeserializationError(f"cannot deserialize: {error}") from error
