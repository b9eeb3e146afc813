"""Hardware descriptions in YAML: read and written."""
