"""Stand-in for sensor_msgs_py: clouds of points in Python."""
