"""Objects as clusters of the points that a depth camera sees."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import tf2_ros
from geometry_msgs.msg import PointStamped, TransformStamped
from ruamel.yaml import YAML
from tf2_geometry_msgs import do_transform_point

from ._camera import IS_ROS2, begin, is_served, node_of, report_unseen, warn

if IS_ROS2:
    from interbotix_perception_msgs.srv import ClusterInfoArray

    _TYPE = "interbotix_perception_msgs/ClusterInfoArray"
else:
    from interbotix_perception_modules.srv import ClusterInfoArray

    _TYPE = "interbotix_perception_modules/ClusterInfoArray"

__all__ = ["InterbotixPointCloudInterface"]

# The values with which the node of ROS 2 declares them, also in filter_params.yaml.
_DEFAULTS: Mapping[str, float] = {
    "x_filter_min": -0.25,
    "x_filter_max": 0.25,
    "y_filter_min": -0.25,
    "y_filter_max": 0.25,
    "z_filter_min": 0.25,
    "z_filter_max": 0.75,
    "voxel_leaf_size": 0.004,
    "plane_max_iter": 50,
    "plane_dist_thresh": 0.005,
    "ror_radius_search": 0.01,
    "ror_min_neighbors": 5,
    "cluster_tol": 0.02,
    "cluster_min_size": 50,
    "cluster_max_size": 1000,
}


class _PointCloud:
    _node: Any = None
    _service: str
    _file = ""

    def _begin(self, filter_ns: str) -> None:
        self._service = f"/{filter_ns}/get_cluster_positions"
        self._values = dict(_DEFAULTS)

    def get_params(self) -> dict[str, float]:
        """Return the filter's parameters."""
        return dict(self._values)

    def set_params(self, param_dict: Mapping[str, float]) -> None:
        """Set all of the filter's parameters.

        Raises:
            KeyError: one is missing.
        """
        for name, default in _DEFAULTS.items():
            self._values[name] = type(default)(param_dict[name])

    def get_filepath(self) -> str:
        """Return the file of the filter's parameters."""
        return self._file

    def load_params(self, filepath: str | None = None) -> None:
        """Read the filter's parameters from a file."""
        result = YAML(typ="safe").load(Path(filepath or self._file).read_text(encoding="utf-8"))
        self.set_params(result["/**"]["ros__parameters"] if "/**" in result else result)

    def save_params(self, filepath: str | None = None) -> None:
        """Write the filter's parameters into a file."""
        values = {"/**": {"ros__parameters": self._values}} if IS_ROS2 else self._values
        with Path(filepath or self._file).open("w", encoding="utf-8") as file:
            YAML(typ="safe").dump(values, file)

    def enable_pipeline(self, enable: bool) -> None:
        """Switch the filter on or off; it has no camera to filter."""

    def get_cluster_positions(
        self,
        num_samples: int = 5,
        period: float = 0.1,
        ref_frame: str | None = None,
        sort_axis: str = "y",
        reverse: bool = False,
        is_parallel: bool = True,
    ) -> tuple[bool, list[dict[str, Any]]]:
        """Return whether there are clusters, and each as a mapping, sorted along an axis.

        `position` is in `ref_frame`, at the top of the cluster where that is parallel to what
        the objects stand on. Where nobody serves the clusters there are none, and the run says so.
        """
        if not is_served(self._service, _TYPE):
            report_unseen(
                "InterbotixPointCloudInterface.get_cluster_positions returns no clusters, as "
                f"nobody serves {self._service}: it"
            )
            return False, []
        samples = []
        for _ in range(num_samples):
            samples.append(self._clusters())
            self._sleep(period)
        if not samples or not samples[0]:
            warn(self._node, "No clusters found...")
            return False, []
        if any(len(sample) != len(samples[0]) for sample in samples):
            warn(self._node, "The number of clusters changes between samples...")
            return False, []
        frame = samples[0][0].frame_id
        try:
            transform = self._lookup(ref_frame or frame, frame)
        except tf2_ros.TransformException:
            warn(self._node, f"Failed to look up the transform from '{ref_frame}' to '{frame}'.")
            return False, []
        tables = [
            self._described(clusters, transform, is_parallel)
            for clusters in zip(*samples, strict=True)
        ]
        axis = {"x": 0, "y": 1, "z": 2}.get(sort_axis)
        if axis is None:
            warn(self._node, f"'{sort_axis}' is not a valid sorting axis. Defaulting to 'y'.")
            axis = 1
        at: int = axis
        tables.sort(key=lambda fields: fields["position"][at], reverse=reverse)
        shown = []
        for number, fields in enumerate(tables, 1):
            fields["name"] = f"cluster_{number}"
            message = TransformStamped()
            message.header.frame_id, message.child_frame_id = ref_frame or frame, fields["name"]
            message.header.stamp = self._now()
            place = message.transform.translation
            place.x, place.y, place.z = fields["position"]
            message.transform.rotation.w = 1.0
            shown.append(message)
        self._broadcaster.sendTransform(shown)
        return True, tables

    def _described(
        self, samples: tuple[Any, ...], transform: Any, is_parallel: bool
    ) -> dict[str, Any]:
        def mean(read: Callable[[Any], float]) -> float:
            return float(sum(read(sample) for sample in samples) / len(samples))

        def moved(field: str) -> list[float]:
            stamped = PointStamped()
            for axis in "xyz":
                value = mean(lambda item, axis=axis: getattr(getattr(item, field), axis))  # type: ignore[misc]
                setattr(stamped.point, axis, value)
            point = do_transform_point(stamped, transform).point
            return [point.x, point.y, point.z]

        position = moved("position")
        if is_parallel:
            position[2] = moved("min_z_point")[2]
        return {
            "name": "",
            "position": position,
            "yaw": 0,
            "color": [mean(lambda c, k=k: getattr(c.color, k)) for k in "rgb"],  # type: ignore[misc]
            "num_points": mean(lambda item: item.num_points),
        }

    _broadcaster: Any

    def _clusters(self) -> Any:
        raise NotImplementedError

    def _sleep(self, duration: float) -> None:
        raise NotImplementedError

    def _now(self) -> Any:
        raise NotImplementedError

    def _lookup(self, target: str, source: str) -> Any:
        raise NotImplementedError


def _accessors(name: str, default: float) -> tuple[Callable[[Any], Any], Callable[..., None]]:
    def get(self: Any) -> Any:
        return self._values[name]

    def set_(self: Any, value: float) -> None:
        self._values[name] = type(default)(value)

    get.__doc__, set_.__doc__ = f"Return {name} of the filter.", f"Set {name} of the filter."
    return get, set_


for _name, _default in _DEFAULTS.items():
    _get, _set = _accessors(_name, _default)
    setattr(_PointCloud, f"get_{_name}", _get)
    setattr(_PointCloud, f"set_{_name}", _set)


class _PointCloud1(_PointCloud):
    """The interface of ROS 1."""

    def __init__(self, filter_ns: str = "pc_filter", init_node: bool = False) -> None:
        import rospy

        begin(filter_ns, init_node)
        self._begin(filter_ns)
        self._file = rospy.get_param(f"/{filter_ns}/filter_params", "")
        for name in _DEFAULTS:
            self._values[name] = rospy.get_param(f"/{filter_ns}/{name}", _DEFAULTS[name])
        self._broadcaster = tf2_ros.TransformBroadcaster()
        self.srv_get_cluster_positions = rospy.ServiceProxy(self._service, ClusterInfoArray)
        self._buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(self._buffer)

    def _clusters(self) -> Any:
        return self.srv_get_cluster_positions().clusters

    def _sleep(self, duration: float) -> None:
        import rospy

        rospy.sleep(duration)

    def _now(self) -> Any:
        import rospy

        return rospy.Time.now()

    def _lookup(self, target: str, source: str) -> Any:
        import rospy

        return self._buffer.lookup_transform(target, source, rospy.Time(0), rospy.Duration(4.0))


class _PointCloud2(_PointCloud):
    """The interface of ROS 2."""

    def __init__(
        self, filter_ns: str = "pc_filter", node_inf: Any = None, args: Any = None
    ) -> None:
        self.node_inf = self._node = node_of(node_inf)
        self._begin(filter_ns)
        self._file = self._node.declare_parameter("filter_params", "").value
        for name, default in _DEFAULTS.items():
            self._values[name] = self._node.declare_parameter(name, default).value
        self._broadcaster = tf2_ros.TransformBroadcaster(self._node)
        self.srv_get_cluster_positions = self._node.create_client(ClusterInfoArray, self._service)
        self._buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(self._buffer, self._node)

    params = property(_PointCloud.get_params, _PointCloud.set_params)

    def _clusters(self) -> Any:
        future = self.srv_get_cluster_positions.call_async(ClusterInfoArray.Request())
        self._node.wait_until_future_complete(future)
        return future.result().clusters

    def _sleep(self, duration: float) -> None:
        from rclpy.duration import Duration

        self._node.get_clock().sleep_for(Duration(seconds=duration))

    def _now(self) -> Any:
        return self._node.get_clock().now().to_msg()

    def _lookup(self, target: str, source: str) -> Any:
        from rclpy.duration import Duration
        from rclpy.time import Time

        return self._buffer.lookup_transform(target, source, Time(), Duration(seconds=4.0))


_Base: Any = _PointCloud2 if IS_ROS2 else _PointCloud1


class InterbotixPointCloudInterface(_Base):  # type: ignore[misc]
    """Finds clusters."""
