"""Redundant groups solved one by one, and put together, where all at once are too many states."""
