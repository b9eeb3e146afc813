"""Run a controller on real ROS in the place of the stand-ins."""
