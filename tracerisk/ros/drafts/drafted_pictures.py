"""What a camera that sees nothing would send: small pictures, with the encoding of their topic."""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any

_WIDTH, _HEIGHT = 16, 12  # [pixels]
_GREY = 128
_FAR_MM = 500  # depth of each pixel
_FOCAL = 20.0  # [pixels]
_DEPTH = re.compile(r"depth", re.IGNORECASE)
_MONO = re.compile(r"mono|gr[ae]y|infra|(^|[/_])ir([/_]|$)", re.IGNORECASE)


def picture(type_name: str, names: Iterable[str], frame: str, topic: str) -> dict[str, Any]:
    """Return the fields of one of the `PICTURES` that is sent on a topic in a camera's `frame`.

    `names` are the fields that the message has: each ROS writes the matrices of a camera its way.
    """
    made = {"header": {"stamp": "now", "frame_id": frame}, **PICTURES[type_name](topic)}
    return {name: made[key] for name in names for key in (name, name.lower()) if key in made}


def _image(topic: str) -> dict[str, Any]:
    encoding, pixel = "bgr8", [_GREY] * 3
    if _DEPTH.search(topic):
        encoding, pixel = "16UC1", list(_FAR_MM.to_bytes(2, "little"))
    elif _MONO.search(topic):
        encoding, pixel = "mono8", [_GREY]
    return {
        "height": _HEIGHT, "width": _WIDTH, "encoding": encoding, "is_bigendian": 0,
        "step": _WIDTH * len(pixel), "data": pixel * (_WIDTH * _HEIGHT),
    }  # fmt: skip


def _png(topic: str) -> dict[str, Any]:
    del topic
    rows = (b"\0" + bytes([_GREY]) * _WIDTH) * _HEIGHT
    parts = (
        (b"IHDR", struct.pack(">IIBBBBB", _WIDTH, _HEIGHT, 8, 0, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows, 0)),
        (b"IEND", b""),
    )
    text = b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    )
    return {"format": "png", "data": list(text)}


def _camera(topic: str) -> dict[str, Any]:
    del topic
    x, y = _WIDTH / 2, _HEIGHT / 2
    return {
        "height": _HEIGHT, "width": _WIDTH, "distortion_model": "plumb_bob", "d": [0.0] * 5,
        "k": [_FOCAL, 0.0, x, 0.0, _FOCAL, y, 0.0, 0.0, 1.0],
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [_FOCAL, 0.0, x, 0.0, 0.0, _FOCAL, y, 0.0, 0.0, 0.0, 1.0, 0.0],
    }  # fmt: skip


PICTURES: Mapping[str, Callable[[str], dict[str, Any]]] = {
    "sensor_msgs/Image": _image,
    "sensor_msgs/CompressedImage": _png,
    "sensor_msgs/CameraInfo": _camera,
}
"""The messages that a camera sends, by type."""
