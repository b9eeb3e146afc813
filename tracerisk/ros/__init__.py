"""Stand-ins for the ROS client libraries, in one process and in virtual time."""
