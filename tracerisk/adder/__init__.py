"""Risk annotation blocks in sources: read, computed, merged, inserted."""
