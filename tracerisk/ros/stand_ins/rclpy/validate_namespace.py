"""Checking a namespace."""

from __future__ import annotations

from ._name_rules import check, namespace_fault
from .exceptions import InvalidNamespaceException


def validate_namespace(namespace: str) -> bool:
    """Return True for a namespace that a node may have, with the slash at its start.

    Raises:
        InvalidNamespaceException: it may not.
    """
    return check(namespace, namespace_fault(namespace), InvalidNamespaceException)
