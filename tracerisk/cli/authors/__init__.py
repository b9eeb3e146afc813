"""The verbs for authors of controllers, one file each."""
