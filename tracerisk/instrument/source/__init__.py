"""Reads a controller without running it: functions, calls, values, ROS version."""
