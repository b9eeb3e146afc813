"""What a run brought about: the value, its form in the lock, and the comparison of two."""
