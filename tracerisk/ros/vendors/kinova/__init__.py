"""Kinova's drivers and libraries."""
