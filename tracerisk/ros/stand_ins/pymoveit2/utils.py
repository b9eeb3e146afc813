"""Names of the constants of a message."""

from typing import Any


def enum_to_str(enum_class: Any, enum_value: Any) -> str:
    """Return the name of the constant of a value."""
    for name in dir(enum_class):
        if name.isupper() and getattr(enum_class, name) == enum_value:
            return name
    return "UNKNOWN"
