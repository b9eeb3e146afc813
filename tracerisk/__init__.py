"""Redo the risk assessment of a robot arm at every commit of its ROS controller."""

__version__ = "0.1.0"
