"""The arguments with which a controller may be started, read from its source."""
