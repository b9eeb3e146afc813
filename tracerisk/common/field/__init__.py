"""The field: what many recorded missions show together, as data and as a file."""
