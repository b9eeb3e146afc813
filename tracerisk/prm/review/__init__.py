"""The difference of two risk models, cause by cause."""
