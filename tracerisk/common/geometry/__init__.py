"""Shapes, rotations and meshes: no simulator, no ROS."""
