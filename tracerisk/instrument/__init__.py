"""Find a controller's functions, trace them as they run, and say whose activity is whose."""
