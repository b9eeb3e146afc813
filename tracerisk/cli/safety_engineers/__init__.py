"""The verbs for safety engineers, one file each."""
