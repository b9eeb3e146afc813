"""Interbotix's drivers and libraries."""
