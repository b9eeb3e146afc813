"""Fault trees: gates, events and failure models."""
