"""The version of tracerisk, in a file that imports nothing: every room may name it."""

__version__ = "0.1.0"
