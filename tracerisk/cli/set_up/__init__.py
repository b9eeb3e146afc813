"""The verbs to set up, one file each."""
