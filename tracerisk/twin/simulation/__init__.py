"""The twin: simulated, moved and measured."""
