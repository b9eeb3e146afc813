"""Evidence: failures that were tried on the twin, as data and as a file."""

EVIDENCE_NAME = "tracerisk.evidence"
"""The file's name in a controller's root."""
