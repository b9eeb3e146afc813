"""Read and make clouds of points, as ROS 2 does: as arrays of records."""

from __future__ import annotations

import sys
from collections import namedtuple
from collections.abc import Sequence
from typing import Any

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField

from tracerisk.ros.imports.exported import defined as _defined

DUMMY_FIELD_PREFIX = "unnamed_field"
_KINDS = {
    number: np.dtype(name)
    for number, name in enumerate(
        ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"), 1
    )
}


def dtype_from_fields(fields: Sequence[Any], point_step: int | None = None) -> Any:
    """Return the record type of fields; one with several values is several, `name_0` and on."""
    names, kinds, offsets = [], [], []
    for index, field in enumerate(fields):
        kind = _KINDS[field.datatype]
        name = field.name or f"{DUMMY_FIELD_PREFIX}_{index}"
        for part in range(max(field.count, 1)):
            names.append(f"{name}_{part}" if field.count > 1 else name)
            kinds.append(kind)
            offsets.append(field.offset + part * kind.itemsize)
    described: Any = {"names": names, "formats": kinds, "offsets": offsets}
    if point_step is not None:
        described["itemsize"] = point_step
    return np.dtype(described)


def read_points(
    cloud: Any,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Any = None,
    reshape_organized_cloud: bool = False,
) -> Any:
    """Return the points as an array of records: those at the indices `uvs`, or all."""
    assert isinstance(cloud, PointCloud2), "Cloud is not a sensor_msgs.msg.PointCloud2"
    kind = dtype_from_fields(cloud.fields, cloud.point_step)
    points = np.ndarray((cloud.width * cloud.height,), kind, bytes(cloud.data))
    if bool(sys.byteorder != "little") != bool(cloud.is_bigendian):
        points = points.byteswap()
    if field_names is not None:
        assert all(name in kind.names for name in field_names), (
            "Requested field is not in the fields of the PointCloud!"
        )
        points = points[list(field_names)]
    if skip_nans and not cloud.is_dense:
        kept = np.ones(len(points), bool)
        for name in points.dtype.names:
            kept &= ~np.isnan(points[name])
        points = points[kept]
    if uvs is not None:
        points = points[np.asarray(uvs, int)]
    if reshape_organized_cloud and cloud.height > 1:
        points = points.reshape(cloud.height, cloud.width)
    return points


def read_points_numpy(
    cloud: Any,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Any = None,
    reshape_organized_cloud: bool = False,
) -> Any:
    """Return the points as an array (points, fields); all fields are of one type."""
    points = read_points(cloud, field_names, skip_nans, uvs, reshape_organized_cloud)
    kinds = {points.dtype[name] for name in points.dtype.names}
    assert len(kinds) == 1, "All fields need to have the same datatype. Use `read_points()`"
    return np.stack([points[name] for name in points.dtype.names], axis=-1)


def read_points_list(
    cloud: Any,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Any = None,
) -> list[Any]:
    """Return the points as named tuples."""
    points = read_points(cloud, field_names, skip_nans, uvs)
    kind = namedtuple("Point", points.dtype.names)  # type: ignore[misc]
    return [kind(*point.item()) for point in points]


def create_cloud(header: Any, fields: Sequence[Any], points: Any, step: int | None = None) -> Any:
    """Return a cloud of one row, or of the rows of an array (height, width, fields)."""
    kind = dtype_from_fields(fields, step)
    if not isinstance(points, np.ndarray):
        points = np.array([tuple(point) for point in points], dtype=kind)
    elif points.dtype.names is None:
        given, points = points, np.zeros(points.shape[:-1], kind)
        for index, name in enumerate(kind.names):
            points[name] = given[..., index]
    else:
        points = points.astype(kind)
    rows = np.atleast_2d(points)
    return PointCloud2(
        header=header,
        height=rows.shape[0],
        width=rows.shape[1],
        is_dense=False,
        is_bigendian=sys.byteorder != "little",
        fields=list(fields),
        point_step=kind.itemsize,
        row_step=kind.itemsize * rows.shape[1],
        data=rows.tobytes(),
    )


def create_cloud_xyz32(header: Any, points: Any, step: int | None = None) -> Any:
    """Return a cloud of points (x, y, z) [m]."""
    fields = [
        PointField(name=name, offset=4 * index, datatype=PointField.FLOAT32, count=1)
        for index, name in enumerate("xyz")
    ]
    return create_cloud(header, fields, points, step)


__all__ = _defined(globals())
