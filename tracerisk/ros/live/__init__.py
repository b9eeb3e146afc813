"""A controller on real ROS, with loopback alone, and with the twin as a node beside it."""
