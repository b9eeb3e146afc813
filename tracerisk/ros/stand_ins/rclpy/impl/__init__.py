"""What rclpy keeps inside; programs import parts of it all the same."""
