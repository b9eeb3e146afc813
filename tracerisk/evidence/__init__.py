"""Evidence: failures that were tried on the twin, as data and as a file."""
