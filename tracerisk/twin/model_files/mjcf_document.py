"""Read an MJCF file into one document that names no other file.

Includes are put in place, each within the model's folder; meshes are named by number, and what a
robot does not need (textures, lights, sensors, sizes of buffers) is left out. What can grow a
small text into a huge model is refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tracerisk.errors import Location, RobotError
from tracerisk.twin.model_files.paths import ModelFolder, read_model_text
from tracerisk.twin.urdf.xml_reader import XmlElement, read_xml

MOST_ELEMENTS = 20_000
_MOST_FILES = 64
_MOST_BYTES = 32 * 1024 * 1024  # of all files of the model together
_MOST_MESH_BYTES = 64 * 1024 * 1024  # of all meshes together; what is beyond is not looked at
_MOST_COPIES = 1000  # of a `replicate`, those in it counted with it
_MOST_MADE = 50_000  # elements, those counted that a `replicate` makes
_MOST_ROWS = 2000  # of a height field
_READABLE_MESHES = (".stl", ".obj", ".msh")

_REFUSED = {
    "plugin": "code of others is not run",
    "extension": "code of others is not run",
    "composite": "soft bodies are not simulated",
    "flexcomp": "soft bodies are not simulated",
    "flex": "soft bodies are not simulated",
    "attach": "models within models are not read; write the whole model into one file",
    "model": "models within models are not read; write the whole model into one file",
}
_LEFT_OUT = frozenset(
    {
        "visual", "statistic", "size", "sensor", "custom", "skin", "light", "camera", "texture",
        "hfield", "layer", "deformable",
    }
)  # fmt: skip
_OWN_FOLDERS = ("assetdir", "meshdir", "texturedir", "strippath")
_NO_NUMBER = re.compile(r"(?:^|\s)[+-]?(?:nan|inf|infinity)(?:\s|$)", re.IGNORECASE)
_NAMES = frozenset(
    {"name", "class", "childclass", "file", "mesh", "material", "joint", "body", "site", "model"}
)


@dataclass(frozen=True, slots=True)
class MjcfDocument:
    """An MJCF text without includes or paths of files."""

    text: str
    """The MJCF text, in which meshes have numbered names."""
    locations: tuple[Location, ...]
    """The source file and line of each line of `text`, (n_lines,)."""
    meshes: dict[str, Path]
    """The readable mesh files, by their names in `text`."""
    missing: tuple[str, ...]
    """The names in `text` of meshes without a readable file."""
    files: tuple[Path, ...]
    """All files that were read: the model's own first, then includes and meshes."""
    felt: tuple[str, ...] = ()
    """The sites at which a sensor measures a force or a torque, sorted."""


def read_mjcf_document(text: bytes, file: Path, shown: str, folder: ModelFolder) -> MjcfDocument:
    """Return the document of an MJCF text.

    Raises RobotError with file and line at what is no MJCF, names a file outside the folder, or
    asks for what is refused.
    """
    reader = _Reader(file, shown, folder)
    root = reader.whole(text)
    return reader.document(root)


def _felt(root: XmlElement) -> tuple[str, ...]:
    """Return the sites at which the document's sensors measure a force or a torque, sorted."""
    names = {
        child.attributes.get("site", "")
        for section in root.all("sensor")
        for child in section.children
        if child.tag in ("force", "torque")
    }
    return tuple(sorted(names - {""}))


class _Reader:
    def __init__(self, file: Path, shown: str, folder: ModelFolder) -> None:
        self._folder = folder
        self._shown = shown
        self._files = [file.resolve()]
        self._n_bytes = 0
        self._n_elements = 0
        self._n_made = 0
        self._meshes: dict[str, Path] = {}
        self._missing: list[str] = []
        self._mesh_bytes = 0
        self._dirs: dict[str, str] = {}

    def whole(self, text: bytes) -> XmlElement:
        """Return the root with the children of every include in its place."""
        root = read_xml(text, self._shown)
        if root.tag != "mujoco":
            root.fail("is not the element <mujoco> of an MJCF")
        self._n_bytes = len(text)
        self._expand(root, self._files[0].parent)
        for element in _walked(root):
            if element.tag == "compiler":
                for key in _OWN_FOLDERS:
                    if key in element.attributes:
                        self._dirs[key] = element.attributes.pop(key)
        return root

    def document(self, root: XmlElement) -> MjcfDocument:
        """Return the root as a text without files."""
        felt = _felt(root)
        self._check(root, 1)
        lines: list[str] = []
        locations: list[Location] = []
        _write(root, lines, locations)
        return MjcfDocument(
            "\n".join(lines),
            tuple(locations),
            self._meshes,
            tuple(self._missing),
            (*self._files, *dict.fromkeys(self._meshes.values())),
            felt,
        )

    def _expand(self, element: XmlElement, here: Path) -> None:
        children: list[XmlElement] = []
        for child in element.children:
            self._n_elements += 1
            if self._n_elements > MOST_ELEMENTS:
                child.fail(f"is one too many: at most {MOST_ELEMENTS} elements are read")
            if child.tag == "include":
                children += self._included(child, here)
            else:
                self._expand(child, here)
                children.append(child)
        element.children = children

    def _included(self, element: XmlElement, here: Path) -> list[XmlElement]:
        name = element.string("file")
        path = self._folder.named(name, element)
        if path is None and here != self._folder.base:
            # MuJoCo looks beside the main file first, then beside the file that includes.
            path = self._folder.inside(here / name, name, element.location, element.tag)
        if path is None:
            element.fail(f"there is no file '{name}' below {self._folder.base}")
        if path in self._files:
            element.fail(f"'{name}' is included twice, or by itself; MJCF allows it once")
        if len(self._files) >= _MOST_FILES:
            element.fail(f"is one too many: at most {_MOST_FILES} files are read")
        self._files.append(path)
        shown = _beside(self._shown, path, self._files[0])
        text = read_model_text(path, shown)
        self._n_bytes += len(text)
        if self._n_bytes > _MOST_BYTES:
            element.fail(f"the model holds more than {_MOST_BYTES} bytes")
        root = read_xml(text, shown)
        self._expand(root, path.parent)
        return root.children

    def _check(self, element: XmlElement, copies: int) -> None:
        """Refuse what is not read, name meshes by number, leave out what is not needed."""
        # `<extension>` without a plugin says nothing.
        is_harmless = element.tag == "extension" and not element.children
        if element.tag in _REFUSED and not is_harmless:
            element.fail(f"is not read: {_REFUSED[element.tag]}")
        if element.tag == "replicate":
            count = element.number("count", 1.0)
            copies *= int(max(count, 1.0))
            if copies > _MOST_COPIES:
                element.fail(
                    f"makes {copies} copies, with those it stands in; at most {_MOST_COPIES} are "
                    "made"
                )
        if element.tag == "hfield":
            for key in ("nrow", "ncol"):
                if element.number(key, 0.0) > _MOST_ROWS:
                    element.fail(
                        f"attribute '{key}' is {element.attributes[key]}; at most {_MOST_ROWS}"
                    )
        self._n_made += copies
        if self._n_made > _MOST_MADE:
            element.fail(f"is one too many: copies counted, at most {_MOST_MADE} elements are made")
        for key, value in element.attributes.items():
            if key not in _NAMES and _NO_NUMBER.search(value):
                element.fail(f"attribute '{key}' is '{value}'; give finite numbers")
            if key.startswith("file") and element.tag != "mesh":
                self._folder.named(value, element, below=self._dir("texturedir"))
        if element.tag == "mesh" and "file" in element.attributes:
            self._name_mesh(element)
        if element.tag == "material":
            element.attributes.pop("texture", None)
        for child in element.children:
            self._check(child, copies)
        element.children = [
            xml_element for xml_element in element.children if xml_element.tag not in _LEFT_OUT
        ]

    def _dir(self, key: str) -> str:
        return self._dirs.get(key, self._dirs.get("assetdir", ""))

    def _name_mesh(self, element: XmlElement) -> None:
        written = element.attributes.pop("file")
        name = written.rpartition("/")[2] if self._dirs.get("strippath") == "true" else written
        path = self._folder.named(name, element, below=self._dir("meshdir"))
        own = element.attributes.setdefault("name", Path(written).stem)
        element.attributes.pop("content_type", None)
        suffix = Path(written).suffix.lower()
        size = path.stat().st_size if path is not None else 0
        if (
            path is None
            or suffix not in _READABLE_MESHES
            or self._mesh_bytes + size > _MOST_MESH_BYTES
        ):
            self._missing.append(own)
            # A tetrahedron stands for it until the shapes that use it are taken out.
            element.attributes = {
                "name": own,
                "vertex": "0 0 0  .01 0 0  0 .01 0  0 0 .01",
            }
            return
        self._mesh_bytes += size
        virtual = f"mesh{len(self._meshes)}{suffix}"
        self._meshes[virtual] = path
        element.attributes["file"] = virtual


def _walked(element: XmlElement) -> Iterator[XmlElement]:
    yield element
    for child in element.children:
        yield from _walked(child)


def _beside(shown: str, path: Path, main: Path) -> str:
    """Return how messages name an included file: as the main file, from the same folder."""
    try:
        return str(Path(shown).parent / path.relative_to(main.parent))
    except ValueError:
        return str(path)


def _write(element: XmlElement, lines: list[str], locations: list[Location]) -> None:
    # It loads all that opens addresses of the web.
    from xml.sax.saxutils import quoteattr

    attributes = "".join(f" {key}={quoteattr(value)}" for key, value in element.attributes.items())
    # A quoted line break would put the lines of the text out of step with the locations.
    attributes = attributes.replace("\n", "&#10;")
    locations.append(element.location)
    if not element.children:
        lines.append(f"<{element.tag}{attributes}/>")
        return
    lines.append(f"<{element.tag}{attributes}>")
    for child in element.children:
        _write(child, lines, locations)
    lines.append(f"</{element.tag}>")
    locations.append(element.location)


def error_of_mujoco(reason: str, document: MjcfDocument, shown: str) -> RobotError:
    """Return MuJoCo's refusal of a document as an error at the line of the file it came from."""
    matched = re.search(r"line (\d+)", reason)
    text = re.sub(r"\s+", " ", re.sub(r"[,;]?\s*\(?line \d+(?:, column -?\d+)?\)?", "", reason))
    where = Location(shown)
    if matched and 0 < int(matched[1]) <= len(document.locations):
        where = document.locations[int(matched[1]) - 1]
    return RobotError(f"MuJoCo refuses the model: {text.strip()[:300]}", where)
