"""Frames between the processes of a live run: a header in JSON and bytes, over a stream socket.

Nothing here needs a package: the far ends run under the Python of the installed ROS.
"""

from __future__ import annotations

import json
import os
import socket
import struct
import threading
from collections.abc import Callable, Mapping
from typing import Any

_LENGTHS = struct.Struct("<II")
_MOST = 1 << 30
_CHUNK = 1 << 16

Frame = tuple[dict[str, Any], bytes]
"""What is sent at once: its header, and bytes that belong to it."""


class Link:
    """One end of a socket; several threads may send."""

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        self._lock = threading.Lock()
        self._buffer = bytearray()
        self.is_closed = False

    def fileno(self) -> int:
        """Return the descriptor, for `select`."""
        return self._socket.fileno()

    def send(self, header: Mapping[str, Any], body: bytes = b"") -> None:
        """Send a frame.

        Raises:
            OSError: the other end is gone.
        """
        head = json.dumps(header, separators=(",", ":")).encode()
        with self._lock:
            self._socket.sendall(_LENGTHS.pack(len(head), len(body)) + head + body)

    def receive(self) -> Frame | None:
        """Wait for a frame; None where the other end has closed.

        Raises:
            ValueError: what came is no frame.
        """
        while (frame := self._taken()) is None:
            if not self._fill():
                return None
        return frame

    def waiting(self) -> list[Frame]:
        """Return the frames that have arrived, without waiting for more.

        Raises:
            ValueError: what came is no frame.
        """
        self._socket.setblocking(False)
        try:
            while self._fill():
                pass
        except BlockingIOError:
            pass
        finally:
            self._socket.setblocking(True)
        frames = []
        while (frame := self._taken()) is not None:
            frames.append(frame)
        return frames

    def close(self) -> None:
        """Close this end."""
        self.is_closed = True
        self._socket.close()

    def _fill(self) -> bool:
        try:
            recv = self._socket.recv(_CHUNK)
        except ConnectionError:
            recv = b""
        self._buffer += recv
        self.is_closed = self.is_closed or not recv
        return bool(recv)

    def _taken(self) -> Frame | None:
        if len(self._buffer) < _LENGTHS.size:
            return None
        n_head, n_body = _LENGTHS.unpack_from(self._buffer)
        if n_head + n_body > _MOST:
            raise ValueError(f"a frame of {n_head + n_body} bytes; at most {_MOST} are read")
        end = _LENGTHS.size + n_head + n_body
        if len(self._buffer) < end:
            return None
        head = json.loads(self._buffer[_LENGTHS.size : _LENGTHS.size + n_head])
        body = bytes(self._buffer[_LENGTHS.size + n_head : end])
        del self._buffer[:end]
        if not isinstance(head, dict):
            raise ValueError("the header of a frame is no object")
        return head, body


def end_with(
    link: Link,
    code: int,
    take: Callable[[dict[str, Any]], None] = lambda header: None,  # noqa: ARG005
) -> None:
    """End this process when the other side is gone, which closes last; `take` what it says."""

    def watch() -> None:
        while (frame := link.receive()) is not None:
            take(frame[0])
        os._exit(code)

    threading.Thread(target=watch, daemon=True).start()
