"""Worlds that a real cell may be, and what depends on them."""
