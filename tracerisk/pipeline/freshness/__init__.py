"""What a run depended on, and whether it is still as it was."""
