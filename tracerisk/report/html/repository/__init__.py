"""Pages about a repository: all of its controllers, and how one went over the commits."""
