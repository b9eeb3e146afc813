"""The stages joined: run a controller, annotate it, build its model, solve it."""
