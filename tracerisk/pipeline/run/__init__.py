"""Run a controller in a child process under limits; both ends of that process."""
