"""What several runs, commits or missions show beside each other."""
