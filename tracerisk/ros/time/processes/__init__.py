"""The processes of `multiprocessing`, as threads: the simulated arm cannot be in two processes."""
