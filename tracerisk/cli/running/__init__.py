"""What `tracerisk run` does once its options are read: one run, what it shows, and `--watch`."""
