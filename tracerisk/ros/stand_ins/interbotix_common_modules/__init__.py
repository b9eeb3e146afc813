"""Stand-in for interbotix_common_modules of Interbotix's ROS 1 and ROS 2 toolboxes."""
