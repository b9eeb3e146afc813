"""Marks in instrumented code: the beginning of loops, calls, and what `except` clauses caught."""
