"""A run on the twin as an MCAP file, for viewers and for reading it back."""
