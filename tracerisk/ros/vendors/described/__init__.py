"""A driver that is described, on the graph: what it is asked, and the motions it makes of it."""
