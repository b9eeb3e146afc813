"""Failures of redundant units that stay hidden until the mission ends."""
