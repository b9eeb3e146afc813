"""Hardware descriptions: which components a robot has, and how they fail."""
