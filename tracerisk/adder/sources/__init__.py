"""Sources: find their functions and blocks, insert and remove blocks, write files."""
