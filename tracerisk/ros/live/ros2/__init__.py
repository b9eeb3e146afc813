"""The side of ROS 2 in a live run: the twin's node on rclpy, and a controller's rclpy."""
