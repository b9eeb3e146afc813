"""What programs of rosbuild call first."""

from __future__ import annotations


def load_manifest(package_name: str, bootstrap_version: str = "0.7") -> None:
    """Do nothing: the packages of the workspace are on the path already."""
