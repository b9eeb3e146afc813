"""Nodes of the workspace that are started beside a controller, for what it waits for."""
