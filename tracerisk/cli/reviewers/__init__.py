"""The verbs for reviewers of changes, one file each."""
