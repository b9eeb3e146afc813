"""What `solve` does with each kind of model file."""
