"""Read the robot of a file that a user names: MJCF, URDF or xacro.

Every file that it names stands below one folder, and what may take all memory or time is done in
processes with limits.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.limits import DEFAULT_LIMITS, Limits
from tracerisk.common.text.bounded import in_folder
from tracerisk.errors import Location, RobotError, one_of
from tracerisk.twin.model_files.mjcf import mjcf_robot
from tracerisk.twin.model_files.mjcf_document import read_mjcf_document
from tracerisk.twin.model_files.mjcf_model import compiled_mjcf, mesh_shapes
from tracerisk.twin.model_files.paths import ModelFolder, read_model_text
from tracerisk.twin.robots.known_arms import completed_as_ours, named_as_ours
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.urdf.srdf import Srdf, SrdfGroup, read_srdf
from tracerisk.twin.urdf.urdf import read_urdf
from tracerisk.twin.urdf.xacro_files import expanded_xacro
from tracerisk.twin.urdf.xml_reader import XmlElement, read_xml

_MACRO_SIGNS = (b"<xacro:", b"xmlns:xacro", b"${")
_ALLOWED = ("mujoco (MJCF)", "robot (URDF or xacro)")
_LARGEST_M = 100.0
_HEAVIEST_KG = 1e5
_MOST_MESHES = 500
_MOST_MESH_BYTES = 64 * 1024 * 1024
_READABLE_MESHES = (".stl", ".obj")
_FITS = 0.6  # the share of an SRDF's names that the robot must have


@dataclass(frozen=True, slots=True)
class ModelFile:
    """What a model file describes."""

    robot: Robot
    """The robot."""
    files: tuple[Path, ...]
    """Every file that was read, the model file first."""


def read_model_file(
    path: Path, folder: ModelFolder, *, shown: str | None = None, limits: Limits = DEFAULT_LIMITS
) -> ModelFile:
    """Return the robot of a model file.

    Raises RobotError with file and line when it is malformed or names a file outside the folder,
    LimitError when it takes too much memory or time.
    """
    shown = str(path) if shown is None else shown
    text = read_model_text(path, shown)
    read: tuple[Path, ...] = ()
    # Reported before xacro, which reads without bounds, is asked.
    root = read_xml(text, shown)
    _check_root(root)
    if path.name.endswith(".xacro") or any(sign in text for sign in _MACRO_SIGNS):
        within = folder.allowed
        expanded = expanded_xacro(path, folder.packages, within=within, shown=shown, limits=limits)
        text, read = expanded.text, expanded.files
        root = read_xml(text, shown)
        _check_root(root)
    if root.tag == "mujoco":
        of_mjcf = _of_mjcf(text, path, shown, folder, limits)
    else:
        of_mjcf = _of_urdf(root, text, path, shown, folder, limits)
    of_mjcf = replace(of_mjcf, files=tuple(dict.fromkeys((*of_mjcf.files, *read))))
    name = re.sub(r"[^\w.+-]+", "_", of_mjcf.robot.name)[:80].strip("._") or "robot"
    _check_sizes(of_mjcf.robot, shown)
    return replace(of_mjcf, robot=replace(of_mjcf.robot, name=name))


def _check_root(root: XmlElement) -> None:
    if root.tag == "sdf":
        root.fail("is an SDF, which is not read; give the robot's URDF, xacro or MJCF")
    if root.tag not in ("mujoco", "robot"):
        root.fail(f"describes no robot; {one_of(_ALLOWED, root.tag)}")


def _of_mjcf(text: bytes, path: Path, shown: str, folder: ModelFolder, limits: Limits) -> ModelFile:
    document = read_mjcf_document(text, path, shown, folder)
    model = compiled_mjcf(document, shown, limits)
    names = {body["name"] for body in (*model.bodies, *model.joints)}
    srdf, beside = _srdf_beside(path, model.name, names, folder)
    robot = mjcf_robot(model, shown, path.stem, srdf=srdf, felt=document.felt)
    return _named(robot, srdf, (*document.files, *beside), knows_motors=bool(model.actuators))


def _of_urdf(
    root: XmlElement, text: bytes, path: Path, shown: str, folder: ModelFolder, limits: Limits
) -> ModelFile:
    names = {
        child.attributes.get("name", "")
        for child in root.children
        if child.tag in ("link", "joint")
    }
    srdf, beside = _srdf_beside(path, root.attributes.get("name", ""), names, folder)
    shapes, meshes = _meshes(root, shown, folder, limits)
    robot = read_urdf(text, shown, srdf=srdf, mesh_shape=lambda mesh: shapes.get(_mesh_key(mesh)))
    return _named(robot, srdf, (path.resolve(), *meshes, *beside), knows_motors=False)


def _named(
    robot: Robot, srdf: Srdf | None, files: Iterable[Path], *, knows_motors: bool
) -> ModelFile:
    robot = completed_as_ours(robot, knows_motors=knows_motors)
    if srdf is None:
        robot = named_as_ours(robot)
    return ModelFile(robot, tuple(dict.fromkeys(files)))


def _meshes(
    root: XmlElement, shown: str, folder: ModelFolder, limits: Limits
) -> tuple[dict[str, Shape], tuple[Path, ...]]:
    """Return what bounds each mesh of a URDF that is there, and the files."""
    pair: dict[str, tuple[Path, tuple[float, float, float]]] = {}
    keys: dict[str, str] = {}
    n_bytes = 0
    for link in root.all("link"):
        for kind in ("collision", "visual"):
            for entry in link.all(kind):
                geometry = entry.first("geometry")
                for mesh in () if geometry is None else geometry.all("mesh"):
                    path = folder.named(mesh.string("filename"), mesh)
                    if path is None or path.suffix.lower() not in _READABLE_MESHES:
                        continue
                    key = _mesh_key(mesh)
                    size = path.stat().st_size
                    if key in keys.values() or n_bytes + size > _MOST_MESH_BYTES:
                        continue
                    if len(pair) < _MOST_MESHES:
                        n_bytes += size
                        name = f"mesh{len(pair)}{path.suffix.lower()}"
                        pair[name] = (path, mesh.triple("scale", (1.0, 1.0, 1.0)))
                        keys[name] = key
    shapes = {keys[name]: shape for name, shape in mesh_shapes(pair, shown, limits).items()}
    return shapes, tuple(path for path, _ in pair.values())


def _mesh_key(mesh: XmlElement) -> str:
    return f"{mesh.attributes.get('filename')} {mesh.attributes.get('scale', '')}"


def _srdf_beside(
    path: Path, name: str, names: Iterable[str], folder: ModelFolder
) -> tuple[Srdf | None, tuple[Path, ...]]:
    """Return the SRDF of a model's name beside it, else the one that speaks of its parts.

    Looked for in its folder, and in `config` and `srdf` beside that.
    Raises RobotError when one that is named as the model cannot be read.
    """
    parts = set(names)
    here = path.resolve().parent
    for place in (here, here.parent / "config", here.parent / "srdf"):
        if not place.resolve().is_relative_to(folder.top.resolve()):
            continue
        ranked: list[tuple[float, Path, Srdf]] = []
        for item in in_folder(place, ".srdf"):
            try:
                srdf = read_srdf(read_model_text(item, str(item)), str(item))
            except RobotError:
                if item.stem == path.name.split(".")[0]:
                    raise
                continue
            wanted = {part for group in srdf.groups for part in _parts(group)}
            share = len(wanted & parts) / len(wanted) if wanted else 0.0
            if share >= _FITS:
                ranked.append((share + (srdf.name == name), item, srdf))
        if ranked:
            _, result, srdf = max(ranked, key=lambda row: row[0])
            return srdf, (result,)
    return None, ()


def _parts(group: SrdfGroup) -> Iterator[str]:
    yield from group.joints
    yield from group.links
    for chain in group.chains:
        yield from chain


def _check_sizes(robot: Robot, shown: str) -> None:
    """Refuse what is no arm: links that weigh or measure as much as ships do."""
    where = Location(shown)
    for attachment in robot.attachments:
        far = max(abs(length) for length in attachment.xyz)
        if far > _LARGEST_M:
            raise RobotError(
                f"joint '{attachment.name}' is {far:g} m away from the one before; at most "
                f"{_LARGEST_M:g} m are simulated: is it in millimetres?",
                where,
            )
    for link in robot.links:
        lengths = [*link.centre_of_mass]
        lengths += [value for shape in link.shapes for value in (*shape.size, *shape.xyz)]
        far = max((abs(value) for value in lengths), default=0.0)
        if far > _LARGEST_M:
            raise RobotError(
                f"link '{link.name}' is {far:g} m large; at most {_LARGEST_M:g} m are simulated: "
                "is it in millimetres?",
                where,
            )
        if link.mass > _HEAVIEST_KG:
            raise RobotError(
                f"link '{link.name}' weighs {link.mass:g} kg; at most {_HEAVIEST_KG:g} kg are "
                "simulated",
                where,
            )
