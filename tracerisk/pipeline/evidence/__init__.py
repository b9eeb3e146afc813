"""Campaigns of failures on the twin: draw, run, judge, keep."""
