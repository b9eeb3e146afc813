"""Reports: what an assessment looks like to the people who read it."""
