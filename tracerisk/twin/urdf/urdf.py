"""Read a URDF, with its SRDF where there is one, as a robot of the twin.

Meshes are read by who knows where they stand; a link without any shape is drawn by capsules
between its joints. Wheels and mobile bases stand still. What the file leaves out is assumed as
`robot_assembly` says, and the robot is then marked approximate.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from tracerisk.common.geometry.frames import Triple, roll_pitch_yaw, rotation, triple
from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.text.bounded import finite_number
from tracerisk.twin.robots.outline import outlined
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Link
from tracerisk.twin.urdf.assembly import (
    ASSUMED_MASS,
    LIGHTEST,
    RobotParts,
    assembled_robot,
    hanging,
)
from tracerisk.twin.urdf.srdf import Srdf
from tracerisk.twin.urdf.tree import Tree, read_tree
from tracerisk.twin.urdf.xml_reader import XmlElement, read_xml

MeshShape = Callable[[XmlElement], Shape | None]
"""What stands for a `<mesh>`, in the mesh's own frame; `None` where nothing is known of it."""

_ZERO: Triple = (0.0, 0.0, 0.0)
_FARTHEST = 1.0  # from a link's centre of mass, as a radius of gyration [m]
_RADIUS = (0.008, 0.05)  # of the capsules that stand for meshes, least and greatest [m]


def read_urdf(
    text: str | bytes, file: str, *, srdf: Srdf | None = None, mesh_shape: MeshShape | None = None
) -> Robot:
    """Return the robot of a URDF; groups, states and end effectors are those of the SRDF.

    Without an SRDF each arm is a group named `arm` (`arm_2` and so on), each gripper one named
    `gripper`. Raises RobotError with file and line when it is not a URDF, has no joint that moves,
    or is not a tree.
    """
    root = read_xml(text, file)
    tree = read_tree(root, file)
    if srdf is not None:
        tree = _without_turning_frames(root, tree, srdf)
    links, assumed = _links(root, tree, mesh_shape or (lambda _: None))
    return assembled_robot(
        RobotParts(
            name=root.attributes.get("name", "") or "robot",
            file=file,
            tree=tree,
            links=links,
            assumed=assumed,
            srdf=srdf,
            begins=_begins(root),
        )
    )


def _begins(root: XmlElement) -> dict[str, float]:
    """Return where the simulated hardware of ros2_control puts joints when it starts."""
    begun = {}
    for joint in (joint for system in root.all("ros2_control") for joint in system.all("joint")):
        for state in joint.all("state_interface"):
            is_position = state.attributes.get("name") == "position"
            for param in state.all("param") if is_position else ():
                if param.attributes.get("name") == "initial_value":
                    with suppress(ValueError):
                        begun[joint.string("name")] = finite_number(param.text.strip())
    return begun


def _without_turning_frames(root: XmlElement, tree: Tree, srdf: Srdf) -> Tree:
    """Return the tree with passive joints fixed that carry nothing but a frame: no tool turns."""
    bodies = {
        entry.string("name")
        for entry in root.all("link")
        if any(True for kind in ("inertial", "collision", "visual") for _ in entry.all(kind))
    }
    joints = (
        replace(joint, moves=False)
        if joint.moves
        and joint.name in srdf.passive_joints
        and joint.child not in bodies
        and not any(tree.below(joint.child))
        else joint
        for joint in tree.joints
    )
    return replace(tree, joints=tuple(joints))


def _links(root: XmlElement, tree: Tree, mesh_shape: MeshShape) -> tuple[tuple[Link, ...], bool]:
    """Return the links, and whether some figure of theirs is assumed."""
    attachments = hanging(tree)
    moved = {joint.child for joint in tree.moving}
    assumed = False
    links = []
    for entry in root.all("link"):
        name = tree.place_of(entry.string("name"))
        if name is None:
            continue
        mass, centre, inertia = _inertial(entry)
        if name in moved and mass < LIGHTEST:
            # A frame between two joints, or a link of unknown mass.
            mass, inertia, assumed = ASSUMED_MASS, None, True
        shapes = _primitives(entry, mesh_shape)
        link = Link(name, mass, centre, inertia, shapes, _drawn(entry, mesh_shape))
        drawn = any(True for kind in ("collision", "visual") for _ in entry.all(kind))
        if not shapes and drawn:
            link = outlined(link, outline_radius(name, tree), attachments)
        links.append(link)
    return tuple(links), assumed


def outline_radius(link: str, tree: Tree) -> float:
    """Return the radius of what stands for a mesh: an eighth of the longest way to a joint."""
    spans = [math.hypot(*joint.xyz) for joint in tree.joints if joint.parent == link]
    return min(max(max(spans, default=0.0) / 8, _RADIUS[0]), _RADIUS[1])


def _inertial(
    entry: XmlElement,
) -> tuple[float, Triple, tuple[float, float, float, float, float, float] | None]:
    """Return mass, centre of mass and inertia in the link's axes; the latter may be missing."""
    inertial = entry.first("inertial")
    mass_entry = inertial.first("mass") if inertial is not None else None
    if inertial is None or mass_entry is None:
        return 0.0, _ZERO, None
    mass = max(mass_entry.number("value"), 0.0)
    centre, rpy = inertial.placing()
    tensor = inertial.first("inertia")
    if tensor is None:
        return mass, centre, None
    xx, yy, zz, xy, xz, yz = (
        tensor.number(key, 0.0) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    turn = rotation(rpy)
    full = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
    moments = np.linalg.eigvalsh(full)
    if moments.min() <= 1e-9 or moments.max() > mass * _FARTHEST**2:
        # Placeholders and slips of the sign: no body turns like that.
        return mass, centre, None
    row = (full[0, 0], full[1, 1], full[2, 2], full[0, 1], full[0, 2], full[1, 2])
    a, b, c, d, e, f = (float(value) for value in row)
    return mass, centre, (a, b, c, d, e, f)


def _primitives(entry: XmlElement, mesh_shape: MeshShape) -> tuple[Shape, ...]:
    """Return the primitives of the collision geometry, else of the visual one."""
    for kind in ("collision", "visual"):
        shapes = (_shape(xml_element, mesh_shape) for xml_element in entry.all(kind))
        primitives = [shape for shape in shapes if shape is not None]
        if primitives:
            return tuple(primitives)
    return ()


def _drawn(entry: XmlElement, mesh_shape: MeshShape) -> tuple[Shape, ...]:
    """Return the bounds of the meshes of the visual geometry, else of the collision geometry."""
    for kind in ("visual", "collision"):
        shapes = (_shape(xml_element, mesh_shape) for xml_element in entry.all(kind))
        drawn = tuple(shape for shape in shapes if shape is not None and shape.mesh is not None)
        if drawn:
            return drawn
    return ()


def _shape(entry: XmlElement, mesh_shape: MeshShape) -> Shape | None:
    geometry = entry.first("geometry")
    if geometry is None:
        return None
    xyz, rpy = entry.placing()
    for solid in geometry.children:
        if solid.tag == "box":
            x, y, z = (max(abs(length) / 2, 1e-4) for length in solid.triple("size", _ZERO))
            return Shape("box", (x, y, z), xyz, rpy)
        if solid.tag == "sphere":
            return Shape("sphere", (max(solid.number("radius"), 1e-4),), xyz, rpy)
        if solid.tag in ("cylinder", "capsule"):
            size = (max(solid.number("radius"), 1e-4), max(solid.number("length") / 2, 1e-4))
            return Shape("cylinder" if solid.tag == "cylinder" else "capsule", size, xyz, rpy)
        if solid.tag == "mesh" and (shape := mesh_shape(solid)) is not None:
            return placed(shape, xyz, rpy)
    return None


def placed(shape: Shape, xyz: Triple, rpy: Triple) -> Shape:
    """Return a shape of a frame that stands at `xyz` [m], turned by `rpy` [rad], in its parent."""
    turn = rotation(rpy)
    place = triple(np.array(xyz) + turn @ np.array(shape.xyz))
    return replace(shape, xyz=place, rpy=roll_pitch_yaw(turn @ rotation(shape.rpy)))
