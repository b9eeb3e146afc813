"""Rethink Robotics' drivers and libraries: Baxter and Sawyer."""
