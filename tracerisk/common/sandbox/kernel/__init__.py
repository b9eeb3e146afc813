"""What the sandbox asks of the kernel: rules for files, system calls, control groups."""
