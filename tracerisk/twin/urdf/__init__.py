"""Robots from URDF, SRDF and xacro."""
