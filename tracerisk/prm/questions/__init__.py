"""What-if, uncertainty and pairs of parameters."""
