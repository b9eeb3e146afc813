"""The encodings of images, and the change from one to another.

Names are those of sensor_msgs/image_encodings.h; weights of grey are those of ITU-R BT.601, in
the 14-bit integers that OpenCV takes.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

DEPTHS = {
    "8U": "uint8",
    "8S": "int8",
    "16U": "uint16",
    "16S": "int16",
    "32S": "int32",
    "32F": "float32",
    "64F": "float64",
}
"""The numpy type of each depth, in the order of OpenCV's numbers."""

_TYPE = re.compile(r"(8U|8S|16U|16S|32S|32F|64F)C?(\d*)")
_COLOURS = {
    "mono8": ("8U", "y"),
    "mono16": ("16U", "y"),
    "bgr8": ("8U", "bgr"),
    "rgb8": ("8U", "rgb"),
    "bgra8": ("8U", "bgra"),
    "rgba8": ("8U", "rgba"),
    "bgr16": ("16U", "bgr"),
    "rgb16": ("16U", "rgb"),
    "bgra16": ("16U", "bgra"),
    "rgba16": ("16U", "rgba"),
}
_OTHERS = {
    **{f"bayer_{order}8": ("8U", 1) for order in ("rggb", "bggr", "gbrg", "grbg")},
    **{f"bayer_{order}16": ("16U", 1) for order in ("rggb", "bggr", "gbrg", "grbg")},
    "yuv422": ("8U", 2),
    "yuv422_yuy2": ("8U", 2),
}
_GREY = {"r": 4899, "g": 9617, "b": 1868}
_GREY_BITS = 14


def layout(encoding: str) -> tuple[str, int]:
    """Return depth and channels of an encoding: ("8U", 3) of bgr8.

    Raises:
        ValueError: there is no such encoding.
    """
    if encoding in _COLOURS:
        depth, order = _COLOURS[encoding]
        return depth, len(order)
    if encoding in _OTHERS:
        return _OTHERS[encoding]
    matched = _TYPE.fullmatch(encoding)
    if matched is None:
        known = ", ".join([*_COLOURS, *_OTHERS])
        raise ValueError(
            f"Unrecognized image encoding [{encoding}]; known: {known}, and types as 8UC3"
        )
    return matched[1], int(matched[2] or 1)


def changed(image: Any, begin: str, end: str) -> Any:
    """Return an image of one encoding in another.

    Raises:
        ValueError: an encoding is none, or the change makes no sense or is not served.
    """
    begin_depth, begin_channels = layout(begin)
    end_depth, end_channels = layout(end)
    if begin == end:
        return image
    if end not in _COLOURS:
        if begin_channels != end_channels:
            raise ValueError(f"[{begin}] and [{end}] have different numbers of channels")
        return _as_depth(image, end_depth, 1.0)
    if begin in _OTHERS:
        raise ValueError(
            f"[{begin}] to [{end}]: tracerisk's stand-in turns no raw pattern to colour"
        )
    if begin not in _COLOURS:
        # Of 8UC3 nobody knows the order of the colours.
        if begin_channels == end_channels == 1:
            return _as_depth(image, end_depth, 1.0)
        raise ValueError(
            f"[{begin}] is not a color format. but [{end}] is. The conversion does not make sense"
        )
    recoloured = _recoloured(image, _COLOURS[begin][1], _COLOURS[end][1])
    if begin_depth == end_depth:
        return recoloured
    factor = 65535.0 / 255.0 if end_depth == "16U" else 255.0 / 65535.0
    return _as_depth(recoloured, end_depth, factor)


def _recoloured(image: Any, begin: str, end: str) -> Any:
    if begin == end:
        return image
    opaque = np.iinfo(image.dtype).max
    planes = {name: image[..., i] for i, name in enumerate(begin)} if begin != "y" else {}
    if begin == "y":
        planes = dict.fromkeys("rgb", image)
    if end == "y":
        total = sum(planes[name].astype(np.int64) * weight for name, weight in _GREY.items())
        return ((total + (1 << (_GREY_BITS - 1))) >> _GREY_BITS).astype(image.dtype)
    alpha = planes.get("a", np.full(image.shape[:2], opaque, image.dtype))
    return np.stack([alpha if name == "a" else planes[name] for name in end], axis=-1)


def _as_depth(image: Any, depth: str, factor: float) -> Any:
    """Return numbers of another type: rounded to even and cut off at its ends, as OpenCV does."""
    kind = np.dtype(DEPTHS[depth])
    if image.dtype == kind and factor == 1.0:
        return image
    values = image.astype(np.float64) * factor
    if kind.kind == "f":
        return values.astype(kind)
    limits = np.iinfo(kind)
    return np.clip(np.rint(values), limits.min, limits.max).astype(kind)
