"""Names of files, and the error of what is not found."""

from __future__ import annotations

from collections.abc import Sequence

MANIFEST_FILE = "manifest.xml"
PACKAGE_FILE = "package.xml"
STACK_FILE = "stack.xml"


class ResourceNotFound(Exception):
    """A package is not in the workspace."""

    def __init__(self, msg: str, ros_paths: Sequence[str] | None = None) -> None:
        super().__init__(msg)
        self.ros_paths = ros_paths

    def __str__(self) -> str:
        lines = [str(self.args[0])]
        for number, path in enumerate(self.ros_paths or ()):
            lines.append(f"ROS path [{number}]={path}")
        return "\n".join(lines)
