"""Robots from MJCF, and from any file that a user names."""
