"""What differs between the two versions of ROS in the messages that a bridge passes on."""

from __future__ import annotations

from typing import Any, Literal, Protocol

from tracerisk.ros.messages.ros1_wire import encode as encode1
from tracerisk.ros.messages.ros2_wire import decode as decode2
from tracerisk.ros.messages.ros2_wire import encode as encode2


class Wire(Protocol):
    """How the bytes and descriptions of messages and services are read and written."""

    ros: Literal[1, 2]
    """The version of ROS."""

    def encode(self, message: Any) -> bytes:
        """Return the bytes of a message."""

    def decode(self, body: bytes, kind: Any) -> Any:
        """Return the message of a class that the bytes hold."""

    def content(self, body: bytes, message: Any) -> bytes:
        """Return bytes of a message, which was read of a body, that are the same whenever it is."""

    def message(self, kind: Any) -> dict[str, Any]:
        """Return what a relay must know of a class of messages."""

    def service(self, type_name: str, kind: Any) -> dict[str, Any]:
        """Return what a relay must know of a class of services."""

    def parts(self, kind: Any) -> tuple[Any, Any]:
        """Return the classes of a service's request and response."""

    def number(self, content: bytes, kind: Any) -> int | None:
        """Return the number of its publisher with which a message begins; None if with none."""


class Wire1:
    """The messages of ROS 1, which its nodes know by md5 sums of their texts."""

    ros: Literal[1, 2] = 1

    def encode(self, message: Any) -> bytes:
        """Return the bytes of a message."""
        return encode1(message)

    def decode(self, body: bytes, kind: Any) -> Any:
        """Return the message of a class that the bytes hold."""
        message = kind()
        message.deserialize(body)
        return message

    def content(self, body: bytes, message: Any) -> bytes:  # noqa: ARG002
        """Return the bytes themselves."""
        return body

    def message(self, kind: Any) -> dict[str, Any]:
        """Return type, md5 sum and text of a class of messages."""
        return {"type": kind._type, "md5": kind._md5sum, "text": kind._full_text}

    def service(self, type_name: str, kind: Any) -> dict[str, Any]:
        """Return the type of a service, and the md5 sums of it and its parts."""
        return {
            "type": type_name,
            "md5": kind._md5sum,
            "request_md5": kind._request_class._md5sum,
            "response_md5": kind._response_class._md5sum,
        }

    def parts(self, kind: Any) -> tuple[Any, Any]:
        """Return the classes of a service's request and response."""
        return kind._request_class, kind._response_class

    def number(self, content: bytes, kind: Any) -> int | None:
        """Return the number in the header of a message; None where it has no header."""
        has_header = bool(kind._fields) and kind._fields[0].base == "std_msgs/Header"
        return int.from_bytes(content[:4], "little") if has_header else None


class Wire2:
    """The messages of ROS 2, which its nodes know by the names of their types."""

    ros: Literal[1, 2] = 2

    def encode(self, message: Any) -> bytes:
        """Return the bytes of a message."""
        return encode2(message)

    def decode(self, body: bytes, kind: Any) -> Any:
        """Return the message of a class that the bytes hold."""
        return decode2(body, kind)

    def content(self, body: bytes, message: Any) -> bytes:  # noqa: ARG002
        """Return the bytes without what happened to lie between the values, as padding."""
        return encode2(message)

    def message(self, kind: Any) -> dict[str, Any]:
        """Return the type of a class of messages."""
        return {"type": kind._ros_type}

    def service(self, type_name: str, kind: Any) -> dict[str, Any]:  # noqa: ARG002
        """Return the type of a service."""
        return {"type": type_name}

    def parts(self, kind: Any) -> tuple[Any, Any]:
        """Return the classes of a service's request and response."""
        return kind.Request, kind.Response

    def number(self, content: bytes, kind: Any) -> int | None:  # noqa: ARG002
        """Return None: the transport numbers the messages of ROS 2."""
        return None


def wire_of(interfaces: Any) -> Wire:
    """Return how messages of `interfaces`, of one of the two versions, are passed on."""
    return Wire2() if hasattr(interfaces, "action") else Wire1()
