"""The keyboard of a run: what is typed, and the libraries that read it key by key."""
