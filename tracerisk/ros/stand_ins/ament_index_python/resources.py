"""The index of resources, of which a workspace has one kind: its packages."""

from __future__ import annotations

from .packages import get_packages_with_prefixes

_KIND = "packages"


def get_resource(resource_type: str, resource_name: str) -> tuple[str, str]:
    """Return content and prefix of a resource.

    Raises:
        LookupError: there is no such resource.
    """
    known = get_resources(resource_type)
    if resource_name not in known:
        raise LookupError(
            f"Could not find the resource '{resource_name}' of type '{resource_type}'"
        )
    return "", known[resource_name]


def get_resources(resource_type: str) -> dict[str, str]:
    """Return the prefix of each resource of a type."""
    return get_packages_with_prefixes() if resource_type == _KIND else {}


def has_resource(resource_type: str, resource_name: str) -> str | bool:
    """Return the prefix of a resource, or False."""
    return get_resources(resource_type).get(resource_name, False)
