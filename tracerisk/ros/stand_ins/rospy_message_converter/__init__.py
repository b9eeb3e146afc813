"""Stand-in for rospy_message_converter (ROS 1): messages as dictionaries and as JSON."""
