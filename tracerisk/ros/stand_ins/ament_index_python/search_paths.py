"""Where packages are looked for."""

from __future__ import annotations

from .packages import get_packages_with_prefixes


def get_search_paths() -> list[str]:
    """Return the prefixes of all packages."""
    return list(dict.fromkeys(get_packages_with_prefixes().values()))
