"""What is behind rospy's public modules."""
