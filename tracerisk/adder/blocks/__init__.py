"""The risk block: its fields, its text, and how that is parsed and printed."""
