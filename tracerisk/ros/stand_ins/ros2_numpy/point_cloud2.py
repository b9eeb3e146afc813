"""Clouds of points as record arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField

from tracerisk.ros.imports.exported import defined as _defined

from .registry import converts_from_numpy, converts_to_numpy

DUMMY_FIELD_PREFIX = "__"
_KINDS = {
    number: np.dtype(name)
    for number, name in enumerate(
        ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"), 1
    )
}
_NUMBERS = {kind: number for number, kind in _KINDS.items()}


def fields_to_dtype(fields: Sequence[Any], point_step: int) -> Any:
    """Return the record type of fields, as a list of its parts with the padding between them."""
    parts: list[Any] = []
    offset = 0
    for field in fields:
        while offset < field.offset:
            parts.append((f"{DUMMY_FIELD_PREFIX}{offset}", np.uint8))
            offset += 1
        kind = _KINDS[field.datatype]
        if field.count != 1:
            kind = np.dtype((kind, field.count))
        parts.append((field.name, kind))
        offset += kind.itemsize
    parts += [(f"{DUMMY_FIELD_PREFIX}{at}", np.uint8) for at in range(offset, point_step)]
    return parts


def dtype_to_fields(dtype: Any) -> list[Any]:
    """Return the fields of a record type."""
    made = []
    for name in dtype.names:
        kind, offset = dtype.fields[name][:2]
        count = 1
        if kind.subdtype:
            kind, shape = kind.subdtype
            count = int(np.prod(shape))
        made.append(PointField(name=name, offset=offset, datatype=_NUMBERS[kind], count=count))
    return made


@converts_to_numpy(PointCloud2)
def pointcloud2_to_array(cloud_msg: Any, squeeze: bool = True) -> Any:
    """Return a cloud as a record array (height, width), or (width,) for one row."""
    parts = fields_to_dtype(cloud_msg.fields, cloud_msg.point_step)
    points = np.frombuffer(bytes(cloud_msg.data), np.dtype(parts))
    kept = [name for name, _ in parts if not name.startswith(DUMMY_FIELD_PREFIX)]
    points = points[kept]
    if squeeze and cloud_msg.height == 1:
        return points.reshape(cloud_msg.width)
    return points.reshape(cloud_msg.height, cloud_msg.width)


@converts_from_numpy(PointCloud2)
def array_to_pointcloud2(cloud_arr: Any, stamp: Any = None, frame_id: str | None = None) -> Any:
    """Return a record array as a cloud."""
    points = np.atleast_2d(cloud_arr)
    message = PointCloud2()
    if stamp is not None:
        message.header.stamp = stamp
    if frame_id is not None:
        message.header.frame_id = frame_id
    message.height, message.width = points.shape
    message.fields = dtype_to_fields(points.dtype)
    message.is_bigendian = False
    message.point_step = points.dtype.itemsize
    message.row_step = message.point_step * points.shape[1]
    message.is_dense = all(
        bool(np.isfinite(points[name]).all())
        for name in points.dtype.names or ()
        if np.issubdtype(points.dtype[name].base, np.floating)
    )
    message.data = points.tobytes()
    return message


def merge_rgb_fields(cloud_arr: Any) -> Any:
    """Return points with `r`, `g`, `b` merged into one float `rgb`."""
    r, g, b = (np.asarray(cloud_arr[name], dtype=np.uint32) for name in "rgb")
    merged = ((r << 16) | (g << 8) | b).astype(np.uint32).view(np.float32)
    kept = [name for name in cloud_arr.dtype.names if name not in ("r", "g", "b")]
    made = np.zeros(
        cloud_arr.shape,
        [*((name, cloud_arr.dtype[name]) for name in kept), ("rgb", np.float32)],
    )
    for name in kept:
        made[name] = cloud_arr[name]
    made["rgb"] = merged
    return made


def split_rgb_field(cloud_arr: Any) -> Any:
    """Return points with the float `rgb` split into `r`, `g`, `b`."""
    packed = np.ascontiguousarray(cloud_arr["rgb"]).view(np.uint32)
    kept = [name for name in cloud_arr.dtype.names if name != "rgb"]
    colors = [(name, np.uint8) for name in "rgb"]
    made = np.zeros(cloud_arr.shape, [*((name, cloud_arr.dtype[name]) for name in kept), *colors])
    for name in kept:
        made[name] = cloud_arr[name]
    for name, shift in zip("rgb", (16, 8, 0), strict=True):
        made[name] = (packed >> shift) & 255
    return made


def get_xyz_points(cloud_array: Any, remove_nans: bool = True, dtype: Any = float) -> Any:
    """Return x, y, z of points as an array (n, 3)."""
    if remove_nans:
        is_finite = np.ones(cloud_array.shape, dtype=bool)
        for name in "xyz":
            is_finite &= np.isfinite(cloud_array[name])
        cloud_array = cloud_array[is_finite]
    return np.stack([cloud_array[name] for name in "xyz"], axis=-1).astype(dtype)


def pointcloud2_to_xyz_array(cloud_msg: Any, remove_nans: bool = True) -> Any:
    """Return x, y, z of a cloud as an array (n, 3)."""
    return get_xyz_points(pointcloud2_to_array(cloud_msg), remove_nans=remove_nans)


__all__ = _defined(globals())
