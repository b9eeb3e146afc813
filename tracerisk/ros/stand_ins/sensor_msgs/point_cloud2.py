"""Read and make clouds of points, as ROS 1 does: a point is a tuple of its fields."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Iterator, Sequence
from typing import Any

from sensor_msgs.msg import PointCloud2, PointField  # noqa: F401 - programs take both from here
from sensor_msgs_py import point_cloud2 as arrays

if not hasattr(PointCloud2, "_md5sum"):
    raise ModuleNotFoundError(
        "No module named 'sensor_msgs.point_cloud2': ROS 2 has sensor_msgs_py.point_cloud2",
        name="sensor_msgs.point_cloud2",
    )

__all__ = ["create_cloud", "create_cloud_xyz32", "read_points", "read_points_list"]


def read_points(
    cloud: Any,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Sequence[tuple[int, int]] = (),
) -> Iterator[tuple[Any, ...]]:
    """Yield the points of a cloud, or those in the columns and rows `uvs`."""
    if not isinstance(cloud, PointCloud2):
        raise AssertionError("cloud is not a sensor_msgs.msg.PointCloud2")
    names = None if field_names is None else list(field_names)
    chosen = [v * cloud.width + u for u, v in uvs] or None
    for point in arrays.read_points(cloud, names, skip_nans, chosen):
        yield tuple(point.item())


def read_points_list(
    cloud: Any,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Sequence[tuple[int, int]] = (),
) -> list[Any]:
    """Return the points of a cloud as named tuples."""
    names = [field.name for field in cloud.fields] if field_names is None else list(field_names)
    kind = namedtuple("Point", names)  # type: ignore[misc]
    return [kind(*point) for point in read_points(cloud, names, skip_nans, uvs)]


def create_cloud(header: Any, fields: Sequence[Any], points: Any) -> Any:
    """Return a cloud of one row."""
    return arrays.create_cloud(header, fields, points)


def create_cloud_xyz32(header: Any, points: Any) -> Any:
    """Return a cloud of points (x, y, z) [m]."""
    return arrays.create_cloud_xyz32(header, points)
