"""Start and stop of the C++ half of the real library."""

from collections.abc import Sequence


def roscpp_initialize(args: Sequence[str]) -> None:
    """Begin; the stand-in has no second half to start, so only the arguments are looked at.

    Raises:
        TypeError: an argument is not a string.
    """
    for argument in args:
        if not isinstance(argument, str):
            raise TypeError(f"roscpp_initialize takes a list of strings, not {argument!r} in it")


def roscpp_shutdown() -> None:
    """End; motions that are live go on, as the node move_group is not ended by its clients."""
