"""Recordings of runs as files that other tools open."""
