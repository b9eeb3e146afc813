"""The literals of a source: what it names, sends, and compares with what it is given."""
