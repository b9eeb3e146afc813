"""Stand-in for tf2_sensor_msgs: importing it lets buffers transform clouds of points."""

from .tf2_sensor_msgs import do_transform_cloud, from_msg_msg, to_msg_msg, transform_points

__all__ = ["do_transform_cloud", "from_msg_msg", "to_msg_msg", "transform_points"]
