"""Checking the name of a parameter."""

from __future__ import annotations

from .exceptions import InvalidParameterException


def validate_parameter_name(name: str) -> bool:
    """Return True for a name that a parameter may have: any but an empty one.

    Raises:
        InvalidParameterException: it is empty.
    """
    if not name:
        raise InvalidParameterException(name)
    return True
