"""The robot as data, the shipped robots, and which of them a text names."""
