"""What a `package.xml` says."""

from __future__ import annotations

import stat
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

from .common import PACKAGE_FILE

_MOST_BYTES = 256 * 1024
_DEPENDS = ("depend", "build_depend", "run_depend", "exec_depend", "build_export_depend")


class InvalidManifest(Exception):
    """A manifest is not XML, or lacks what it must have."""


@dataclass
class Depend:
    """A dependency of a package."""

    name: str
    """The name of the package."""
    type: str = "package"
    """What kind of thing it is: `package`."""

    def __str__(self) -> str:
        return self.name


@dataclass
class Manifest:
    """The contents of a package's manifest."""

    filename: str | None = None
    """The path of the `package.xml`; `None` where it was read from no file."""
    name: str | None = None
    """The name of the package; `None` where it is missing."""
    version: str | None = None
    """The version of the package; `None` where it is missing."""
    description: str = ""
    """The description as text."""
    author: str | None = None
    """All authors, separated by commas."""
    license: str = ""
    """All licenses, separated by commas."""
    url: str = ""
    """The first URL; empty where there is none."""
    type: str = "package"
    """The kind of thing that the manifest describes: `package`."""
    is_catkin: bool = True
    """Whether it is a catkin package."""
    licenses: list[str] = field(default_factory=list)
    """The licenses, in order."""
    depends: list[Depend] = field(default_factory=list)
    """The packages that it depends on, without duplicates."""
    rosdeps: list[Depend] = field(default_factory=list)
    """System dependencies; always empty, because they are in `depends` as well."""
    exports: list[ET.Element] = field(default_factory=list)
    """The elements of its `export`."""

    def get_export(self, tag: str, attr: str) -> list[str]:
        """Return an attribute of each export with a tag."""
        values = (export.get(attr) for export in self.exports if export.tag == tag)
        return [value for value in values if value is not None]


def parse_manifest_file(dirpath: str, manifest_name: str = PACKAGE_FILE) -> Manifest:
    """Return the manifest of the package in a folder.

    Raises:
        InvalidManifest: it is not XML, or not one of a package.
        OSError: there is none.
    """
    file = Path(dirpath) / PACKAGE_FILE
    try:
        root = ET.fromstring(_text_of(file))
    except ET.ParseError as error:
        raise InvalidManifest(f"[{file}] invalid XML: {error}") from error
    if root.tag != "package":
        raise InvalidManifest(f"[{file}] must have a top-level 'package' element")
    licenses = [(text.text or "").strip() for text in root.findall("license")]
    names = dict.fromkeys((e.text or "").strip() for tag in _DEPENDS for e in root.findall(tag))
    authors = [(text.text or "").strip() for text in root.findall("author")]
    export = root.find("export")
    return Manifest(
        filename=str(file),
        name=_text(root, "name"),
        version=_text(root, "version"),
        description=_text(root, "description") or "",
        author=", ".join(authors),
        license=", ".join(licenses),
        url=_text(root, "url") or "",
        licenses=licenses,
        depends=[Depend(name) for name in names],
        exports=list(export) if export is not None else [],
    )


def _text_of(file: Path) -> bytes:
    """Return what a manifest holds; no manifest is large, or defines entities."""
    status = file.stat()
    if not stat.S_ISREG(status.st_mode) or status.st_size > _MOST_BYTES:
        raise InvalidManifest(f"[{file}] is not a file of at most {_MOST_BYTES // 1024} kB")
    text = file.read_bytes()
    if b"<!ENTITY" in text:
        raise InvalidManifest(f"[{file}] defines entities, which are not read")
    return text


def _text(root: ET.Element, tag: str) -> str | None:
    findtext = root.findtext(tag)
    return None if findtext is None else findtext.strip()
