"""Stand-in for rostopic: the types of topics that somebody publishes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rospy
from roslib.message import get_message_class

from tracerisk.ros.imports.exported import defined as _defined


class ROSTopicException(Exception):
    """Something is wrong with a topic."""


class ROSTopicIOException(ROSTopicException):
    """The master does not answer."""


def get_topic_type(
    topic: str, blocking: bool = False
) -> tuple[str | None, str | None, Callable[[Any], Any] | None]:
    """Return type and name of a topic, and a function that takes the field named behind it.

    Three times None where nobody publishes it; `blocking` waits until somebody does.
    """
    while True:
        topic_type = _found(topic)
        if topic_type is not None:
            return topic_type
        if not blocking or rospy.is_shutdown():
            return None, None, None
        rospy.sleep(0.1)


def get_topic_class(
    topic: str, blocking: bool = False
) -> tuple[Any, str | None, Callable[[Any], Any] | None]:
    """Return class and name of a topic, and a function that takes the field named behind it.

    Raises:
        ROSTopicException: its type is not known.
    """
    type_name, name, evaluate = get_topic_type(topic, blocking)
    if type_name is None:
        return None, None, None
    kind = get_message_class(type_name)
    if kind is None:
        raise ROSTopicException(f"Cannot load message class for [{type_name}]")
    return kind, name, evaluate


def find_by_type(topic_type: str) -> list[str]:
    """Return the topics that are published with a type."""
    return [name for name, kind in rospy.get_published_topics() if kind == topic_type]


def _found(topic: str) -> tuple[str, str, Callable[[Any], Any] | None] | None:
    wanted = rospy.resolve_name(topic)
    for name, kind in rospy.get_published_topics():
        if name == wanted:
            return kind, name, None
        if wanted.startswith(name + "/"):
            return kind, name, _field(wanted.removeprefix(name + "/").split("/"))
    return None


def _field(path: list[str]) -> Callable[[Any], Any]:
    def evaluate(message: Any) -> Any:
        for name in path:
            message = getattr(message, name)
        return message

    return evaluate


__all__ = _defined(globals())
