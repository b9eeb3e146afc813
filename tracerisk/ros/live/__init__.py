"""A controller on real ROS 1: a master of its own on loopback, with the twin as a node."""
