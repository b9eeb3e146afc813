"""Runs of a controller in other worlds, and what depends on these."""
