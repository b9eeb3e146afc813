"""Dobot's drivers and library."""
