"""Addresses of nodes, and the headers with which connections between them begin.

A run has no network: its one address is loopback's.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping
from io import BytesIO
from typing import Any
from urllib.parse import urlparse

from tracerisk.ros.graph.runtime import current

from .rosenv import ROS_HOSTNAME, ROS_IP, ROS_IPV6

_LENGTH = struct.Struct("<I")
_HTTP_PORT = 80


class ROSHandshakeException(Exception):
    """A header is none."""


def parse_http_host_and_port(url: str | None) -> tuple[str, int]:
    """Return host and port of a URL.

    Raises:
        ValueError: it has no protocol or no host, or a port that is not a number.
    """
    parts = urlparse(url or "")
    if not parts.scheme or not parts.hostname:
        raise ValueError("not a valid URL")
    return parts.hostname, parts.port or _HTTP_PORT


def get_address_override() -> str | None:
    """Return the address that the command line or the environment gives to this node."""
    import sys

    for argument in (*current().argv, *sys.argv):
        name, separator, value = argument.partition(":=")
        if separator and name in ("__hostname", "__ip"):
            return value
    return os.environ.get(ROS_HOSTNAME, os.environ.get(ROS_IP))


def use_ipv6() -> bool:
    """Return whether the environment chooses IPv6."""
    return os.environ.get(ROS_IPV6) == "on"


def is_local_address(hostname: str) -> bool:
    """Return whether a host is this machine."""
    return hostname == "localhost" or _is_loopback(hostname)


def get_local_address() -> str:
    """Return the address of this node."""
    return get_address_override() or get_local_addresses()[0]


def get_local_addresses() -> list[str]:
    """Return the addresses of this machine."""
    return ["::1", "127.0.0.1"] if use_ipv6() else ["127.0.0.1"]


def get_bind_address(address: str | None = None) -> str:
    """Return the address on which a node with this address would listen."""
    own = get_address_override() if address is None else address
    if own != "localhost" and not _is_loopback(own or ""):
        return "::" if use_ipv6() else "0.0.0.0"
    if use_ipv6():
        return "::1"
    return str(own) if str(own).startswith("127.") else "127.0.0.1"


def get_host_name() -> str:
    """Return the name of this node's host."""
    return get_local_address()


def create_local_xmlrpc_uri(port: int) -> str:
    """Return the URI of a server of this node."""
    return f"http://{get_host_name()}:{port}/"


def _is_loopback(address: str) -> bool:
    return address.startswith("127.") or address == "::1"


def encode_ros_handshake_header(header: Mapping[Any, Any]) -> bytes:
    """Return a header as it goes over a connection: fields `key=value`, each behind its length."""
    pairs = sorted((_to_bytes(key), _to_bytes(value)) for key, value in header.items())
    fields = [key + b"=" + value for key, value in pairs]
    body = b"".join(_LENGTH.pack(len(field)) + field for field in fields)
    return _LENGTH.pack(len(body)) + body


def decode_ros_handshake_header(header_str: bytes) -> dict[str, str]:
    """Return the fields of a header; what follows it is passed over.

    Raises:
        ROSHandshakeException: it is cut short, or a field is none.
    """
    (size,) = _LENGTH.unpack_from(header_str)
    body = header_str[_LENGTH.size :]
    if size > len(body):
        raise ROSHandshakeException(
            f"Incomplete header. Expected {size} bytes but only have {len(body)}"
        )
    handshake_header, at = {}, 0
    while at < size:
        (length,) = _LENGTH.unpack_from(body, at)
        at += _LENGTH.size
        if length == 0 or at + length > size:
            raise ROSHandshakeException(f"Invalid line length in handshake header: {length}")
        key, separator, value = body[at : at + length].decode().partition("=")
        if not separator:
            raise ROSHandshakeException(f"Invalid line in handshake header: [{key}]")
        handshake_header[key.strip()] = value
        at += length
    return handshake_header


def read_ros_handshake_header(sock: Any, b: BytesIO, buff_size: int) -> dict[str, str]:
    """Read a header from a socket; what comes behind it stays in `b`.

    Raises:
        ROSHandshakeException: the connection ends before the header does, or it is none.
    """
    while True:
        read = sock.recv(buff_size)
        if not read:
            raise ROSHandshakeException(
                "connection from sender terminated before handshake header received. "
                f"{b.tell()} bytes were received."
            )
        b.write(read)
        data = b.getvalue()
        if len(data) >= _LENGTH.size:
            end = _LENGTH.size + _LENGTH.unpack_from(data)[0]
            if len(data) >= end:
                b.seek(0)
                b.truncate()
                b.write(data[end:])
                return decode_ros_handshake_header(data)


def write_ros_handshake_header(sock: Any, header: Mapping[Any, Any]) -> int:
    """Write a header to a socket; return how many bytes it has."""
    data = encode_ros_handshake_header(header)
    sock.sendall(data)
    return len(data)


def _to_bytes(text: Any) -> bytes:
    return text if isinstance(text, bytes) else str(text).encode()
