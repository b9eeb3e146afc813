"""Checking the name of a topic or a service as a program gives it."""

from __future__ import annotations

from ._name_rules import check, topic_name_fault
from .exceptions import InvalidServiceNameException, InvalidTopicNameException

TOPIC_SEPARATOR_STRING = "/"


def validate_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True for a name that may be one: relative, private, with substitutions.

    Raises:
        InvalidTopicNameException: it may not, and is one of a topic.
        InvalidServiceNameException: it may not, and is one of a service.
    """
    error = InvalidServiceNameException if is_service else InvalidTopicNameException
    return check(name, topic_name_fault(name), error)
