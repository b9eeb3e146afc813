"""Run a controller on real ROS 1 in the place of the stand-ins."""
