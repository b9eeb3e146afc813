"""What a run lacked: looked up, drafted, and judged at the end of the run."""
