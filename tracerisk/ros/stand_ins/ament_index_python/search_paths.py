"""Where packages are looked for."""

from __future__ import annotations

from tracerisk.ros.graph.runtime import current


def get_search_paths() -> list[str]:
    """Return the folders that hold the packages of the workspace."""
    return sorted({str(folder.parent) for folder in current().packages.values()})
