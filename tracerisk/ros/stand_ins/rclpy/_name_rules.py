"""What a name of a node, a namespace or a topic must be: the rules of rmw and rcl.

Each function returns None for a name that may be, else what is wrong and at which character.
"""

from __future__ import annotations

import re
from collections.abc import Callable

Fault = tuple[str, int]

_LONGEST_FULL_NAME = 247
_LONGEST_NODE_NAME = 255
_SUBSTITUTION = re.compile(r"\{([^{}]*)\}")


def check(name: str, fault: Fault | None, error: Callable[..., Exception]) -> bool:
    """Return True for a name without a fault; raise the error of a name, which says the fault."""
    if fault is not None:
        raise error(name, *fault)
    return True


def node_name_fault(name: str) -> Fault | None:
    """Return what is wrong with the name of a node."""
    if not name:
        return "node name must not be empty", 0
    odd = re.search(r"\W", name, re.ASCII)
    if odd is not None:
        message = "node name must not contain characters other than alphanumerics or '_'"
        return message, odd.start()
    if name[0].isdigit():
        return "node name must not start with a number", 0
    if len(name) > _LONGEST_NODE_NAME:
        return f"node name must not be longer than {_LONGEST_NODE_NAME}", _LONGEST_NODE_NAME
    return None


def namespace_fault(name: str) -> Fault | None:
    """Return what is wrong with a namespace; it begins with a slash."""
    return None if name == "/" else _absolute_fault("namespace", name)


def full_topic_name_fault(name: str) -> Fault | None:
    """Return what is wrong with the full name of a topic or a service."""
    return _absolute_fault("topic name", name)


def topic_name_fault(name: str) -> Fault | None:
    """Return what is wrong with a topic's or a service's name as a program gives it.

    It may be relative, begin with `~/` and hold substitutions like `{node}`.
    """
    if not name:
        return "topic name must not be empty", 0
    if name.endswith("/"):
        return "topic name must not end with a forward slash", len(name) - 1
    odd = re.search(r"[^\w/~{}]", name, re.ASCII)
    if odd is not None:
        message = (
            "topic name must not contain characters other than alphanumerics, '_', '/', '~', '{' "
            "or '}'"
        )
        return message, odd.start()
    tilde = name.find("~", 1)
    if tilde > 0:
        return "topic name must not have a tilde (~) elsewhere than at its start", tilde
    if name.startswith("~") and name[1:2] not in ("", "/"):
        return "tilde (~) must be followed by a forward slash", 1
    return _substitution_fault(name) or _token_fault("topic name", name)


def _substitution_fault(name: str) -> Fault | None:
    for match in _SUBSTITUTION.finditer(name):
        inner = match[1]
        if not inner or re.search(r"\W", inner, re.ASCII):
            message = (
                "substitution name must not contain characters other than alphanumerics or '_'"
            )
            return message, match.start(1)
        if inner[0].isdigit():
            return "substitution name must not start with a number", match.start(1)
    rest = _SUBSTITUTION.sub(lambda match: "_" * len(match[0]), name)
    brace = re.search(r"[{}]", rest)
    return None if brace is None else ("topic name has unbalanced curly braces", brace.start())


def _absolute_fault(what: str, name: str) -> Fault | None:
    if not name:
        return f"{what} must not be empty", 0
    if not name.startswith("/"):
        return f"{what} must be absolute, it must begin with a '/'", 0
    if name.endswith("/"):
        return f"{what} must not end with a '/'", len(name) - 1
    odd = re.search(r"[^\w/]", name, re.ASCII)
    if odd is not None:
        message = f"{what} must not contain characters other than alphanumerics, '_' or '/'"
        return message, odd.start()
    if len(name) > _LONGEST_FULL_NAME:
        return f"{what} must not be longer than {_LONGEST_FULL_NAME}", _LONGEST_FULL_NAME
    return _token_fault(what, name)


def _token_fault(what: str, name: str) -> Fault | None:
    doubled = name.find("//")
    if doubled >= 0:
        return f"{what} must not contain repeated '/'", doubled + 1
    begun = re.search(r"(^|/)\d", name)
    if begun is not None:
        return f"{what} token must not start with a number", begun.end() - 1
    return None
