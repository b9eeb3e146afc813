"""Prefixes of ROS as colcon and catkin lay them out, made for tests."""

from collections.abc import Mapping
from pathlib import Path

MANIFEST = "<package format='2'><name>{name}</name>{needs}</package>\n"


class Prefix:
    """A folder into which packages are installed, of ROS 2 or of ROS 1."""

    def __init__(self, path: Path, ros: int = 2) -> None:
        self.path = path
        self._ros = ros
        (path / "share").mkdir(parents=True, exist_ok=True)
        if ros == 1:
            (path / ".catkin").touch()

    def install(
        self, name: str, files: Mapping[str, str] | None = None, needs: tuple[str, ...] = ()
    ) -> Path:
        """Install a package with files in its share folder; return that folder."""
        share = self.path / "share" / name
        share.mkdir(parents=True, exist_ok=True)
        said = "".join(f"<exec_depend>{need}</exec_depend>" for need in needs)
        (share / "package.xml").write_text(MANIFEST.format(name=name, needs=said))
        if self._ros == 2:
            index = self.path / "share/ament_index/resource_index/packages"
            index.mkdir(parents=True, exist_ok=True)
            (index / name).touch()
        write(share, files or {})
        return share

    def python(self, files: Mapping[str, str], folder: str = "lib/python3.10/site-packages") -> str:
        """Install Python modules; return the folder that a shell puts on PYTHONPATH."""
        write(self.path / folder, files)
        return str(self.path / folder)


def write(top: Path, files: Mapping[str, str]) -> None:
    """Write files below a folder."""
    for name, text in files.items():
        path = top / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
