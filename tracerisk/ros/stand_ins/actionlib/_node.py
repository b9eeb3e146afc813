"""What clients and servers share: names, the types of an action, what goes over the wire."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import rospy
from rospy import names
from rospy._node import node
from rospy.msg import sent_copy

from tracerisk.ros.graph.failures import callback_failed

from .exceptions import ActionException


@dataclass(frozen=True, slots=True)
class ActionParts:
    """The message classes of an action."""

    type_name: str
    """The type of the action, `package/Name`."""
    messages: tuple[Any, Any, Any]
    """The classes of goal, result and feedback, (3,)."""
    wrappers: tuple[Any, Any, Any]
    """The classes of action goal, action result and action feedback, (3,)."""


def action_parts(spec: Any) -> ActionParts:
    """Return the parts of an action's message class, `FibonacciAction`.

    Raises:
        ActionException: it is not an action's.
    """
    try:
        action = spec()
        wrappers = (action.action_goal, action.action_result, action.action_feedback)
        messages = (wrappers[0].goal, wrappers[1].result, wrappers[2].feedback)
    except (AttributeError, TypeError) as error:
        raise ActionException(f"Type is not an action spec: {spec}") from error
    return ActionParts(
        spec._type.removesuffix("Action"),
        (type(messages[0]), type(messages[1]), type(messages[2])),
        (type(wrappers[0]), type(wrappers[1]), type(wrappers[2])),
    )


def action_name(ns: str) -> str:
    """Return the global name of an action, remapped."""
    if node().is_initialized:
        return str(rospy.resolve_name(rospy.remap_name(ns)))
    return str(names.resolve_name_without_node_name(ns))


def is_shut_down() -> bool:
    """Return whether the node has shut down; asking moves no clock."""
    return bool(node().is_shutdown)


def call_back(call: Callable[[], object], whose: str) -> None:
    """Call the callback of a client or a server; what it raises is logged, as rospy does."""
    try:
        call()
    except Exception as error:  # noqa: BLE001 - the controller's; rospy logs it and goes on
        if not is_shut_down():
            shown = "".join(traceback.format_exception(error)).rstrip()
            rospy.logerr("bad callback of action %s\n%s", whose, shown)
            callback_failed(f"a callback of action {whose}", error)


def sent(message: Any) -> Any:
    """Return a message as it comes out of the wire.

    Raises:
        SerializationError: a field holds what its type cannot take.
    """
    return sent_copy(message, type(message))
