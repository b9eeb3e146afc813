"""Message packages that an installed ROS 1 lacks, made for it from our texts."""
