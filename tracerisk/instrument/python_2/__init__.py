"""What Python 2 means by the syntax that Python 3 shares, for sources that are converted to run."""
