"""The controller's code as the stand-ins see it: frames, threads, what it lacks."""
