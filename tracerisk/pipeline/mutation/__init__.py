"""Changes of a controller, one at a time: planned, run on the twin, and compared."""
