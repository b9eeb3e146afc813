"""What goes wrong in the use of the library."""


class InterbotixException(Exception):
    """The library is not used as it must be."""
