"""What a name of a node, a namespace or a topic must be: the rules of rmw and rcl.

Each function returns None for a name that may be, else what is wrong and at which character.
"""

from __future__ import annotations

import re
from collections.abc import Callable

Fault = tuple[str, int]

_LONGEST_FULL_NAME = 247
_LONGEST_NODE_NAME = 255
_TOKEN = "topic name token must not start with a number"
_UNMATCHED = "topic name must not have unmatched (unbalanced) curly braces '{}'"
_BARE_TILDE = "topic name must not have a tilde '~' that is not followed by a forward slash '/'"


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
        return f"node name length should not exceed '{_LONGEST_NODE_NAME}'", _LONGEST_NODE_NAME
    return None


def namespace_fault(name: str) -> Fault | None:
    """Return what is wrong with a namespace; it begins with a slash."""
    return None if name == "/" else _absolute_fault("namespace", name)


def full_topic_name_fault(name: str) -> Fault | None:
    """Return what is wrong with the full name of a topic or a service."""
    return _absolute_fault("topic name", name)


def topic_name_fault(name: str) -> Fault | None:
    """Return what is wrong with a topic's or a service's name as a program gives it.

    It may be relative, begin with `~/` and hold substitutions like `{node}`. What it expands to
    may still be no full name: repeated slashes are found there.
    """
    if not name:
        return "topic name must not be empty string", 0
    if name[0].isdigit():
        return _TOKEN, 0
    if name.endswith("/"):
        return "topic name must not end with a forward slash", len(name) - 1
    fault = _character_fault(name)
    begun = re.search(r"/\d", name)
    # As in rcl, which looks at the second character unless it is the last one.
    has_bare_tilde = len(name) > 2 and name[0] == "~" and name[1] != "/"
    if fault is not None or not (begun or has_bare_tilde):
        return fault
    if has_bare_tilde:
        return _BARE_TILDE, 1
    assert begun is not None
    return _TOKEN, begun.end() - 1


def _character_fault(name: str) -> Fault | None:
    """Return the first character that may not stand where it stands."""
    opened: int | None = None
    for place, character in enumerate(name):
        is_letter = re.match(r"\w", character, re.ASCII) is not None
        if character == "~":
            if place > 0:
                return "topic name must not have tilde '~' unless it is the first character", place
        elif character == "}":
            if opened is None:
                return _UNMATCHED, place
            opened = None
        elif opened is not None:
            if not is_letter:
                return (
                    "substitution name must not contain characters other than alphanumerics or '_'"
                ), place
            if place == opened + 1 and character.isdigit():
                return "substitution name must not start with a number", place
        elif character == "{":
            opened = place
        elif not is_letter and character != "/":
            return (
                "topic name must not contain characters other than alphanumerics, '_', '~', '{', "
                "or '}'"
            ), place
    return None if opened is None else (_UNMATCHED, opened)


def _absolute_fault(what: str, name: str) -> Fault | None:
    if not name:
        return f"{what} must not be empty", 0
    if not name.startswith("/"):
        return f"{what} must be absolute, it must lead with a '/'", 0
    is_namespace = what == "namespace"
    if name.endswith("/"):
        unless = ", unless only a '/'" if is_namespace else ""
        return f"{what} must not end with a '/'{unless}", len(name) - 1
    odd = re.search(r"[^\w/]", name, re.ASCII)
    if odd is not None:
        message = f"{what} must not contain characters other than alphanumerics, '_', or '/'"
        return message, odd.start()
    doubled = name.find("//")
    if doubled >= 0:
        return f"{what} must not contain repeated '/'", doubled + 1
    begun = re.search(r"/\d", name)
    if begun is not None:
        return f"{what} must not have a token that starts with a number", begun.end() - 1
    if len(name) > _LONGEST_FULL_NAME:
        called = what if is_namespace else "topic length"
        return f"{called} should not exceed '{_LONGEST_FULL_NAME}'", _LONGEST_FULL_NAME
    return None
