"""Which addresses belong to a contained run: those of its own network that its parts listen on."""

from __future__ import annotations

import errno
import os
from functools import lru_cache
from typing import Any

_ANY = ("", "0.0.0.0", "::", "localhost", "ip6-localhost")
_REUSE = 2  # SO_REUSEADDR


def is_of_run(event: str, sock: Any, address: Any) -> bool:
    """Return whether what a socket is about to do with an address stays within the run.

    `event` is that of Python's audit hooks. Where the run has a network of its own it may bind to
    any address, and connect to and send to loopback's where something listens.
    """
    if not has_own_network():
        return False
    if event == "socket.bind" or address is None:
        return True
    is_local = isinstance(address, tuple) and len(address) >= 2 and _is_loopback(address[0])
    return is_local and _is_taken(sock, address)


def address_text(given: Any) -> str:
    """Return an address of a socket in words."""
    if isinstance(given, tuple) and len(given) >= 2:
        return f"{given[0]}:{given[1]}"
    return os.fsdecode(given) if isinstance(given, bytes | str) else str(given)


@lru_cache(maxsize=1)
def has_own_network() -> bool:
    """Return whether this process may listen: a contained one may in a network of its own."""
    import _socket

    try:
        sock = _socket.socket(_socket.AF_INET, _socket.SOCK_STREAM)
    except OSError:
        return False
    try:
        sock.bind(("127.0.0.1", 0))
    except OSError:
        return False
    finally:
        sock.close()
    return True


def _is_loopback(host: Any) -> bool:
    import ipaddress

    name = host.decode(errors="replace") if isinstance(host, bytes) else str(host)
    if name in _ANY or name == os.uname().nodename:
        return True
    try:
        return ipaddress.ip_address(name.partition("%")[0]).is_loopback
    except ValueError:
        return False


def _is_taken(sock: Any, address: tuple[Any, ...]) -> bool:
    """Return whether something in the network has an address: nobody else can be bound to it."""
    import _socket

    trial = _socket.socket(sock.family, sock.type)
    try:
        trial.setsockopt(_socket.SOL_SOCKET, _REUSE, int(sock.type == _socket.SOCK_STREAM))
        trial.bind(address)
    except OSError as error:
        return error.errno == errno.EADDRINUSE
    finally:
        trial.close()
    return False
