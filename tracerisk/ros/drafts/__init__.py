"""Drafted values for what a controller lacks."""
