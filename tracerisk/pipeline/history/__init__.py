"""What git keeps, and one writer at a time."""
