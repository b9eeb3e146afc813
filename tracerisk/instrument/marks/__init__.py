"""Marks in instrumented code: the begin of loops, calls, and what `except` clauses caught."""
