"""Homogeneous matrices, quaternions (x, y, z, w) and Euler angles, as ROS programs name them."""
