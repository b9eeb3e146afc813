"""Ends a run that repeats itself, only idles, or stands still."""
