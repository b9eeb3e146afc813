"""Values of options, read from the text of the command line.

Each function is the `type` of arguments; argparse prints what it raises with the option's name.
"""

from __future__ import annotations


def _refused(message: str) -> Exception:
    """Return the error at which the parser says where it stands."""
    import argparse

    return argparse.ArgumentTypeError(message)


def probability(text: str) -> float:
    """Read a probability of the command line."""
    value = _number(text)
    if not 0.0 <= value <= 1.0:
        raise _refused(f"{text} is not a probability; allowed: 0 to 1")
    return value


def percentage(text: str) -> float:
    """Read a percentage of the command line, which may be above 100."""
    value = _number(text)
    if not 0.0 <= value < 1e9:
        raise _refused(f"{text} is not a percentage from 0 up")
    return value


def positive(text: str) -> float:
    """Read a number above 0 of the command line."""
    value = _number(text)
    if not 0.0 < value < 1e9:
        raise _refused(f"{text} is not a number above 0 and below 1e9")
    return value


def all_positive(text: str) -> tuple[float, ...]:
    """Read numbers above 0 with commas between them."""
    return tuple(map(positive, text.split(",")))


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise _refused(f"{text!r} is not a number") from None


def cycles(text: str) -> int:
    """Read how many cycles a mission has, from 1 up."""
    value = count(text)
    if value < 1:
        raise _refused(f"{text} is below 1")
    return value


def count(text: str) -> int:
    """Read a whole number of the command line, from 0 up."""
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise _refused(f"{text!r} is not a whole number from 0 up")
    return int(text)


def shard(text: str) -> tuple[int, int]:
    """Read which part of a campaign to run, as in 1/4."""
    index, slash, of = text.partition("/")
    if slash and index.isdecimal() and of.isdecimal() and len(of) <= 5:
        pair = int(index), int(of)
        if 1 <= pair[0] <= pair[1] <= 10_000:
            return pair
    raise _refused(f"'{text}': expected I/N such as 1/4, I from 1 to N")
