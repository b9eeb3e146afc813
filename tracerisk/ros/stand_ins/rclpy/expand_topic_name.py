"""Full names of topics."""

from __future__ import annotations

from ._name_rules import Fault, namespace_fault, node_name_fault, topic_name_fault


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Return the full name that a topic's name has in a node of a name and a namespace.

    Raises:
        TypeError: one of the three is no text.
        ValueError: one of the three is no name that ROS takes.
    """
    for given in (topic_name, node_name, node_namespace):
        if not isinstance(given, str):
            raise TypeError(f"name must be a str, not {type(given).__name__}")
    faults: tuple[tuple[str, str, Fault | None], ...] = (
        ("topic name", topic_name, topic_name_fault(topic_name)),
        ("node name", node_name, node_name_fault(node_name)),
        ("node namespace", node_namespace, namespace_fault(node_namespace)),
    )
    for what, name, fault in faults:
        if fault is not None:
            raise ValueError(f"{what} '{name}' is invalid: {fault[0]}")
    return expanded(topic_name, node_name, node_namespace)


def expanded(name: str, node_name: str, namespace: str) -> str:
    """Return the full name of one that is known to be good.

    Raises:
        ValueError: it holds a substitution that is not known.
    """
    text = name.replace("{node}", node_name)
    for key in ("{ns}", "{namespace}"):
        text = text.replace(key, namespace)
    if "{" in text:
        known = "{node}, {ns} and {namespace}"
        raise ValueError(f"unknown substitution in the name '{name}'; there are {known}")
    space = namespace.rstrip("/")
    if text.startswith("~"):
        return f"{space}/{node_name}{text[1:]}"
    if text.startswith("/"):
        return text
    return f"{space}/{text}"
