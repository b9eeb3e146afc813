"""What a camera would send: small pictures of nothing, or large ones of what is looked for."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from tracerisk.ros.drafts.pictures.seen_in_pictures import Seen
from tracerisk.ros.messages.pictures import PICTURE

_SMALL, _LARGE = (16, 12), (640, 480)  # [pixels]
DEPTHS = "16UC1"
"""The encoding of a picture of depths, in which nothing is seen."""
_GREY = 128
_FAR_MM = 500  # depth of each pixel
_FOCAL = 1.25  # of the width
_PLACES = ((0.25, 0.25), (0.5, 0.5), (0.75, 0.75))
"""Where it is seen in turn, as shares of the width and the height."""
_BESIDE = (0.9, 0.25)  # the place of what somebody else has seen, as shares of both
_SIDE, _STEP_M = 5, 0.03  # points along a side of a patch, and from one to the next [m]
# A camera that is called a depth camera or sensor sends colours on its `image_raw`, too.
_DEPTH = re.compile(r"depth(?!_?(camera|cam|sensor)\b)", re.IGNORECASE)
_MONO = re.compile(r"mono|gr[ae]y|infra|(^|[/_])ir([/_]|$)", re.IGNORECASE)


def picture(
    type_name: str, names: Iterable[str], frame: str, topic: str, *, is_large: bool = False
) -> dict[str, Any]:
    """Return the fields of one of the `PICTURES` that is sent on a topic in a camera's `frame`.

    `names` are the fields that the message has: each ROS writes the matrices of a camera its way.
    It is as large as a camera's if `is_large`, for what is seen in it or has pixels as its place.
    """
    size = _LARGE if is_large else _SMALL
    made = {"header": {"stamp": "now", "frame_id": frame}, **PICTURES[type_name](topic, size)}
    keys = [*names, PICTURE]
    return {name: made[key] for name in keys for key in (name, name.lower()) if key in made}


def with_seen(message: Mapping[str, Any], seen: Seen) -> Iterator[dict[str, Any]]:
    """Yield a drafted picture with what is `seen` in it, each time at another place."""
    plain = message[PICTURE]
    width, height = plain["size"]
    for right, down in _PLACES:
        at = [round(right * width), round(down * height)]
        if seen.dictionary:
            marker = {"dictionary": seen.dictionary, "id": seen.number, "at": at}
            yield {**message, PICTURE: {**plain, "markers": [marker]}}
        else:
            disc = {"color": list(seen.color), "at": at}
            yield {**message, PICTURE: {**plain, "discs": [disc]}}


def box_in_picture(center: Iterable[str]) -> dict[str, Any]:
    """Return a vision_msgs/BoundingBox2D in a large picture [pixels].

    `center` are the fields of its centre, which each distribution writes its way. It is off
    the middle: what a camera at the arm's base sees there stands beside the base.
    """
    (right, down), (width, height) = _BESIDE, _LARGE
    at = {"x": right * width, "y": down * height}
    place = {"position": at} if "position" in center else at
    return {"center": {**place, "theta": 0.0}, "size_x": width / 10, "size_y": height / 10}


def _image(topic: str, size: tuple[int, int]) -> dict[str, Any]:
    encoding, fill = "bgr8", _GREY
    if _DEPTH.search(topic):
        encoding, fill = DEPTHS, _FAR_MM
    elif _MONO.search(topic):
        encoding = "mono8"
    return {PICTURE: {"size": list(size), "encoding": encoding, "fill": fill}}


def _png(topic: str, size: tuple[int, int]) -> dict[str, Any]:
    del topic
    return {PICTURE: {"size": list(size), "fill": _GREY}}


def _camera(topic: str, size: tuple[int, int]) -> dict[str, Any]:
    del topic
    width, height = size
    x, y, focal = width / 2, height / 2, _FOCAL * width
    return {
        "height": height, "width": width, "distortion_model": "plumb_bob", "d": [0.0] * 5,
        "k": [focal, 0.0, x, 0.0, focal, y, 0.0, 0.0, 1.0],
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [focal, 0.0, x, 0.0, 0.0, focal, y, 0.0, 0.0, 0.0, 1.0, 0.0],
    }  # fmt: skip


def cloud(position: Sequence[float]) -> dict[str, Any]:
    """Return a sensor_msgs/PointCloud2 of a level patch around a place [m], grey."""
    x, y, z = position
    steps = [_STEP_M * (i - _SIDE // 2) for i in range(_SIDE)]
    rgb = _GREY << 16 | _GREY << 8 | _GREY
    points = [struct.pack("<fffI", x + dx, y + dy, z, rgb) for dx in steps for dy in steps]
    size, floats = len(points[0]), 7
    names = ("x", "y", "z", "rgb")
    return {
        "height": 1, "width": len(points), "is_bigendian": False, "is_dense": True,
        "fields": [
            {"name": name, "offset": 4 * i, "datatype": floats, "count": 1}
            for i, name in enumerate(names)
        ],
        "point_step": size, "row_step": size * len(points), "data": list(b"".join(points)),
    }  # fmt: skip


PICTURES: Mapping[str, Callable[[str, tuple[int, int]], dict[str, Any]]] = {
    "sensor_msgs/Image": _image,
    "sensor_msgs/CompressedImage": _png,
    "sensor_msgs/CameraInfo": _camera,
}
"""The messages that a camera sends, by type."""
