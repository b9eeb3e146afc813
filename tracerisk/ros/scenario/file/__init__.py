"""The scenario file: its text, the marks in it, and how it is read."""
