"""The description of a driver that nobody has described, drafted from its messages."""
