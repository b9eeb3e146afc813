"""The scenario file, and the world that it describes."""
