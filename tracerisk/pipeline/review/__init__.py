"""Review: what a change of sources, told by git, does to the risk."""
