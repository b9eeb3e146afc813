"""How models and results show themselves in a notebook, and as graphs."""
