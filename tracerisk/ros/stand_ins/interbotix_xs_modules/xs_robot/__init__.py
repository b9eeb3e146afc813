"""Robots of the X series for ROS 2."""
