"""What a run brought about, made of what was recorded."""
