"""Parameter files (ROS 2)."""

from .params import load_from_ros_params_file, save_to_ros_params_file

__all__ = ["load_from_ros_params_file", "save_to_ros_params_file"]
