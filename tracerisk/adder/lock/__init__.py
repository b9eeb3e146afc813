"""`tracerisk.lock` and the digests in blocks: what the tool wrote last."""
