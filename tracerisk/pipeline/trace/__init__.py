"""From a recording to a trace and its verdict."""
