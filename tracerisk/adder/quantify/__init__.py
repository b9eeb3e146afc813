"""Trace x hardware description: the failure probability of units in each visit."""
