"""Faults of a robot's parts: data, and what they do to the physics and to what is measured."""
