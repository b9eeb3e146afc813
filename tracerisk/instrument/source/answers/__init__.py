"""The answers of calls that a controller looks at, read from its sources alone."""
