"""Failure figures of hardware: where they come from, how far they may be off, their update."""
