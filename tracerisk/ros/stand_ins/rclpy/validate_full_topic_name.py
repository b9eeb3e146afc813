"""Checking the full name of a topic or a service."""

from __future__ import annotations

from ._name_rules import check, full_topic_name_fault
from .exceptions import InvalidServiceNameException, InvalidTopicNameException


def validate_full_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True for a full name that may be one: it begins with a slash.

    Raises:
        InvalidTopicNameException: it may not, and is one of a topic.
        InvalidServiceNameException: it may not, and is one of a service.
    """
    error = InvalidServiceNameException if is_service else InvalidTopicNameException
    return check(name, full_topic_name_fault(name), error)
