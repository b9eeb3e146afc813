"""Niryo's drivers and libraries."""
