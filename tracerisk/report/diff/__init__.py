"""A change of risk in words: for a terminal and for a pull request."""
