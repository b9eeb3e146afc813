"""Gazebo's services and models on the twin."""
