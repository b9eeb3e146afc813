"""Probabilities, distributions, elimination, tables: no model."""
