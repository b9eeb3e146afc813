"""Files as a contained controller sees them, and which of them it reads."""
