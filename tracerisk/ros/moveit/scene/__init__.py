"""The planning scene: its objects, the changes to them, and its topics."""
