"""Which robot a controller drives."""
