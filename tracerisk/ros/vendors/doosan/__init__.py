"""Doosan's drivers and library."""
