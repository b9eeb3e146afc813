"""Checking the name of a node."""

from __future__ import annotations

from ._name_rules import check, node_name_fault
from .exceptions import InvalidNodeNameException


def validate_node_name(node_name: str) -> bool:
    """Return True for a name that a node may have.

    Raises:
        InvalidNodeNameException: it may not.
    """
    return check(node_name, node_name_fault(node_name), InvalidNodeNameException)
