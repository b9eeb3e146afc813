"""The index of resources: packages, and what the indexes of installed prefixes list besides."""

from __future__ import annotations

from pathlib import Path

from tracerisk.common.sandbox.ros_prefix import AMENT_INDEX

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
    prefix = known[resource_name]
    file = Path(prefix, AMENT_INDEX, resource_type, resource_name)
    return file.read_text(encoding="utf-8") if file.is_file() else "", prefix


def get_resources(resource_type: str) -> dict[str, str]:
    """Return the prefix of each resource of a type."""
    packages = get_packages_with_prefixes()
    if resource_type == _KIND:
        return packages
    resources: dict[str, str] = {}
    for prefix in dict.fromkeys(packages.values()):
        folder = Path(prefix, AMENT_INDEX, resource_type)
        for file in sorted(folder.iterdir()) if folder.is_dir() else ():
            if file.is_file() and not file.name.startswith("."):
                resources.setdefault(file.name, prefix)
    return resources


def has_resource(resource_type: str, resource_name: str) -> str | bool:
    """Return the prefix of a resource, or False."""
    return get_resources(resource_type).get(resource_name, False)
