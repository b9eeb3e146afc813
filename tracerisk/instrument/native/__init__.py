"""What the preloaded probe records of compiled nodes, and the names of their functions."""
