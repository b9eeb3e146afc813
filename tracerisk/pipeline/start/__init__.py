"""What a repository needs to begin with tracerisk, and the templates of it."""
