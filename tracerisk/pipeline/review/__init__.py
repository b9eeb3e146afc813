"""Review: what a change of sources, as git reports it, does to the risk."""
