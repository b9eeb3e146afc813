"""What traces of compiled controllers need besides."""
