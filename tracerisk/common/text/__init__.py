"""Text and YAML of strangers: bounded, with places, safe to print."""
