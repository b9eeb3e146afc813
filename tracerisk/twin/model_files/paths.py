"""The files that a model file names: where they stand, and that none stands outside its folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote, urlsplit

from tracerisk.common.sandbox.ros_prefix import readable_folders
from tracerisk.common.text.bounded import regular_file
from tracerisk.errors import Location, RobotError
from tracerisk.twin.urdf.xml_reader import MOST_BYTES, XmlElement

_PACKAGE_SCHEMES = ("package", "model")


@dataclass(frozen=True, slots=True)
class ModelFolder:
    """The folders in which the files of a model may stand."""

    base: Path
    """The folder from which relative names start."""
    top: Path
    """The folder below which files are read, beside the workspace's packages."""
    packages: Mapping[str, Path] = field(default_factory=dict)
    """The folders of the workspace's packages, by package name."""

    @property
    def allowed(self) -> tuple[Path, ...]:
        """The folders in which files may be."""
        return (self.top, *readable_folders(self.packages.values()))

    def named(self, name: str, element: XmlElement, *, below: str = "") -> Path | None:
        """Return the file that an element names, `None` where it is not there.

        `below` is the folder that the file's settings put before relative names.
        Raises RobotError at the element when the name leads out of the folders that are allowed.
        """
        try:
            parts = urlsplit(name)
        except ValueError as error:
            element.fail(f"'{name}' names no file: {error}")
        if parts.scheme in _PACKAGE_SCHEMES:
            package = self.packages.get(parts.netloc)
            if package is None:
                return None
            path = package / unquote(parts.path).lstrip("/")
        elif parts.scheme == "file":
            path = self.base / unquote(parts.netloc + parts.path)
        elif parts.scheme and "//" in name:
            element.fail(
                f"'{name}' is not read; allowed: package://, model://, file:// and names of files"
            )
        else:
            path = self.base / below / name
        return self.inside(path, name, element.location, element.tag)

    def inside(self, path: Path, name: str, location: Location, tag: str) -> Path | None:
        """Return the file with its links resolved, `None` where there is none.

        Raises RobotError when it lies outside the folders that are allowed.
        """
        try:
            resolved = path.resolve()
            is_there = resolved.is_file()
            if resolved.is_symlink():
                resolved.stat()  # From Python 3.13 on a circle of links is resolved to itself.
        except (OSError, RuntimeError, ValueError) as error:
            # Links in a circle, names too long, zero bytes.
            raise RobotError(f"<{tag}>: '{name[:80]}' names no file: {error}", location) from error
        if not any(resolved.is_relative_to(folder.resolve()) for folder in self.allowed):
            raise RobotError(
                f"<{tag}>: '{name}' lies outside {self.top}, and only files below it are read; "
                "put the file there, or take this line out",
                location,
            )
        return resolved if is_there else None


def read_model_text(path: Path, shown: str) -> bytes:
    """Return the text of a model file.

    Raises RobotError when it is not a readable file, or is empty, too large or evidently not XML.
    """
    where = Location(shown)
    try:
        if not path.exists():
            raise RobotError("there is no such file", where)
        if not path.is_file():
            raise RobotError("is not a file; give the robot's MJCF, URDF or xacro file", where)
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise RobotError(f"holds {size} bytes; at most {MOST_BYTES} are read", where)
        with regular_file(path) as stream:
            text = stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise RobotError(f"cannot be read: {error.strerror or error}", where) from error
    if not text.strip():
        raise RobotError("is empty; give the robot's MJCF, URDF or xacro file", where)
    begin = text[:1024].lstrip(b"\xef\xbb\xbf \t\r\n").lower()
    if begin.startswith((b"<!doctype html", b"<html")):
        raise RobotError(
            "is an HTML page; download the file itself, as GitHub gives it under 'Raw'", where
        )
    if begin.startswith(b"version https://git-lfs"):
        raise RobotError("is a pointer of Git LFS; fetch the file itself: git lfs pull", where)
    return text
