"""Images as arrays (height, width[, channels])."""

from __future__ import annotations

import re
import sys
from typing import Any

import numpy as np
from sensor_msgs.msg import Image

from .registry import converts_from_numpy, converts_to_numpy

__all__ = ["image_to_numpy", "numpy_to_image"]

_NAMED = {"rgb": 3, "rgba": 4, "bgr": 3, "bgra": 4, "mono": 1}
_CHANNELS = re.compile(r"(rgba?|bgra?|mono|bayer_(?:rggb|bggr|gbrg|grbg))(8|16)")
_OPENCV = re.compile(r"(8|16|32|64)(U|S|F)C([1-4])")
_KINDS = {"U": "uint", "S": "int", "F": "float"}


def _described(encoding: str) -> tuple[Any, int]:
    named, opencv = _CHANNELS.fullmatch(encoding), _OPENCV.fullmatch(encoding)
    if named is not None:
        return np.dtype(f"uint{named[2]}"), _NAMED.get(named[1], 1)
    if opencv is not None and not (opencv[2] == "U" and opencv[1] in ("32", "64")):
        return np.dtype(f"{_KINDS[opencv[2]]}{opencv[1]}"), int(opencv[3])
    raise TypeError(f"Unrecognized encoding {encoding}")


@converts_to_numpy(Image)
def image_to_numpy(msg: Any) -> Any:
    """Return an image as an array.

    Raises:
        TypeError: its encoding is not known.
    """
    kind, channels = _described(msg.encoding)
    kind = kind.newbyteorder(">" if msg.is_bigendian else "<")
    flat = np.frombuffer(bytes(msg.data), dtype=np.uint8).reshape(msg.height, msg.step)
    width = msg.width * channels * kind.itemsize
    data = np.ascontiguousarray(flat[:, :width]).view(kind)
    data = data.reshape(msg.height, msg.width, channels)
    return data[..., 0] if channels == 1 else data


@converts_from_numpy(Image)
def numpy_to_image(arr: Any, encoding: str) -> Any:
    """Return an array as an image.

    Raises:
        TypeError: the encoding is not known, or is not that of the array.
    """
    kind, expected = _described(encoding)
    if arr.ndim not in (2, 3):
        raise TypeError("Array must be two or three dimensional")
    height, width, channels = (*arr.shape, 1)[:3]
    if expected != channels:
        raise TypeError(f"Array has {channels} channels, {encoding} requires {expected}")
    if arr.dtype.type != kind.type:
        raise TypeError(f"Array is {arr.dtype.type}, {encoding} requires {kind.type}")
    solid = np.ascontiguousarray(arr)
    message = Image(encoding=encoding, height=height, width=width)
    message.data = solid.tobytes()
    message.step = solid.strides[0]
    order = arr.dtype.byteorder
    message.is_bigendian = int(order == ">" or (order == "=" and sys.byteorder == "big"))
    return message
