"""Files of packages by the folders of an install space."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rospkg import ResourceNotFound, RosPack

from tracerisk.errors import one_of
from tracerisk.ros.imports.exported import defined as _defined

_FOLDERS = ("bin", "etc", "include", "lib", "libexec", "share", "src")
# Where the sources of a package have what an install space has in these folders.
_OF_SOURCES = {"share": ("",), "libexec": ("scripts", "nodes", "bin", ""), "lib": ("scripts", "")}


def find_in_workspaces(
    search_dirs: Sequence[str] | None = None,
    project: str | None = None,
    path: str | None = None,
    _workspaces: object = None,
    considered_paths: list[str] | None = None,
    first_matching_workspace_only: bool = False,
    first_match_only: bool = False,
    workspace_to_source_spaces: object = None,
    source_path_to_packages: object = None,
) -> list[str]:
    """Return the paths that exist of `path` in the folders of a package, or of all packages.

    Raises:
        ValueError: a folder is not one of those of an install space.
    """
    folders = list(search_dirs or _FOLDERS)
    unknown = [folder for folder in folders if folder not in _FOLDERS]
    if unknown:
        raise ValueError(f"Unsupported search_dirs: {', '.join(unknown)}; {one_of(_FOLDERS)}")
    packages = RosPack()
    tops = []
    for name in [project] if project else packages.list():
        try:
            tops.append(Path(packages.get_path(name)))
        except ResourceNotFound:
            continue
    paths: list[str] = []
    for top in tops:
        for below in dict.fromkeys(part for name in folders for part in _OF_SOURCES.get(name, ())):
            wanted = str(top / below / (path or ""))
            if considered_paths is not None:
                considered_paths.append(wanted)
            if Path(wanted).exists() and wanted not in paths:
                paths.append(wanted)
        if paths and (first_match_only or first_matching_workspace_only):
            return paths[:1] if first_match_only else paths
    return paths


__all__ = _defined(globals())
