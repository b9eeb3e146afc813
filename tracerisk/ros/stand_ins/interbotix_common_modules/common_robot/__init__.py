"""The node that the parts of a robot share (ROS 2)."""

from .robot import InterbotixRobotNode

__all__ = ["InterbotixRobotNode"]
