"""What the replay shows, as data: bodies with their shapes, and how joints move them.

No physics engine is needed for it: a robot's links and a scene's bodies are primitives, and where
they are follows from the positions of joints and of free objects.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Literal

from tracerisk.common.geometry.rotation import Quaternion, quaternion_of
from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.looks.look import Piece
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Attachment

BodyKind = Literal["robot", "fixture", "object", "declared"]

FREE_COLUMNS = 7  # position and quaternion (w, x, y, z)


@dataclass(frozen=True, slots=True)
class Body:
    """A body in the frame of its parent, and how a joint moves it."""

    name: str
    """Name of the link, fixture, object or declared body."""
    kind: BodyKind
    """What the body is."""
    parent: int
    """Index of the parent body; -1 for the world."""
    xyz: tuple[float, float, float]
    """Position in the parent's frame [m]."""
    quaternion: Quaternion
    """Orientation in the parent's frame (w, x, y, z)."""
    shapes: tuple[Shape, ...]
    """Primitive shapes in the body's frame."""
    joint: Literal["hinge", "slide", "free"] | None = None
    """How the body moves: about or along `axis`, or freely; `None` for fixed."""
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Unit vector of a hinge or slide in the body's frame."""
    column: int = -1
    """First column of the frames that moves it: one [rad or m], seven for `free`; -1 for none."""
    element: str | None = None
    """Name of the joint or gripper that drives it; `None` for none."""
    triangles: tuple[float, ...] = field(default=())
    """Corners of shapes that are not primitives, nine numbers a triangle [m]."""
    look: tuple[Piece, ...] = ()
    """What is drawn in place of the shapes; empty where these are."""
    since_s: float = 0.0
    """Time from which it is there [s]."""
    until_s: float | None = None
    """Time from which it is there no more [s]; `None` for ever."""


def scene_bodies(robot: Robot, scene: Scene) -> tuple[Body, ...]:
    """Return fixtures, objects and links, each after its parent.

    Columns are the robot's joints in its order, then seven for each object in the scene's.
    """
    fixtures = [
        Body(fixture.name, "fixture", -1, fixture.xyz, quaternion_of(fixture.rpy), fixture.shapes)
        for fixture in scene.fixtures
    ]
    n_joints = len(robot.joints)
    objects = [
        Body(
            name=graspable_object.name,
            kind="object",
            parent=-1,
            xyz=graspable_object.xyz,
            quaternion=quaternion_of(graspable_object.rpy),
            shapes=graspable_object.shapes,
            joint="free",
            column=n_joints + FREE_COLUMNS * index,
        )
        for index, graspable_object in enumerate(scene.objects)
    ]
    return (*fixtures, *objects, *_links(robot, scene, len(fixtures) + len(objects)))


def _links(robot: Robot, scene: Scene, before: int) -> list[Body]:
    shapes = {link.name: link.shapes for link in robot.links}
    columns = {joint.name: index for index, joint in enumerate(robot.joints)}
    slides = {joint.name for joint in robot.joints if joint.type == "prismatic"}
    drives = {name: grip.name for grip in robot.grippers for name in grip.joints}
    base = robot.base_link
    root_turn = quaternion_of(scene.robot_rpy)
    bodies = [Body(base, "robot", -1, scene.robot_xyz, root_turn, shapes[base])]
    places = {base: before}
    children: dict[str, list[Attachment]] = {}
    for attachment in robot.attachments:
        children.setdefault(attachment.parent, []).append(attachment)
    waiting = list(reversed(children.get(base, ())))
    while waiting:
        attachment = waiting.pop()
        name, parent = attachment.name, bodies[places[attachment.parent] - before]
        moved = name in columns
        places[attachment.child] = before + len(bodies)
        bodies.append(
            Body(
                name=attachment.child,
                kind="robot",
                parent=places[attachment.parent],
                xyz=attachment.xyz,
                quaternion=quaternion_of(attachment.rpy),
                shapes=shapes[attachment.child],
                joint=("slide" if name in slides else "hinge") if moved else None,
                axis=_unit(attachment.axis) if moved else (0.0, 0.0, 1.0),
                column=columns.get(name, -1),
                # What is fixed to a link moves with it.
                element=drives.get(name, name) if moved else parent.element,
            )
        )
        waiting += reversed(children.get(attachment.child, ()))
    return bodies


def bodies_data(bodies: Iterable[Body]) -> list[dict[str, Any]]:
    """Return bodies as JSON has them, without what is not set; lengths to 1 um."""
    return [_body_data(body) for body in bodies]


def _body_data(body: Body) -> dict[str, Any]:
    body_data: dict[str, Any] = {
        "name": body.name,
        "kind": body.kind,
        "parent": body.parent,
        "xyz": _rounded(body.xyz, 6),
        "quat": _rounded(body.quaternion, 9),
        "shapes": [_shape_data(shape) for shape in body.shapes],
    }
    if body.joint is not None:
        body_data |= {"joint": body.joint, "column": body.column}
        if body.joint != "free":
            body_data["axis"] = _rounded(body.axis, 9)
    if body.element is not None:
        body_data["element"] = body.element
    if body.triangles:
        body_data["triangles"] = _rounded(body.triangles, 4)
    if body.look:
        body_data["look"] = [_piece_data(piece) for piece in body.look]
    if body.since_s > 0.0:
        body_data["since"] = round(body.since_s, 6)
    if body.until_s is not None:
        body_data["until"] = round(body.until_s, 6)
    return body_data


def _shape_data(shape: Shape) -> dict[str, Any]:
    shape_data: dict[str, Any] = {"kind": shape.kind, "size": _rounded(shape.size, 6)}
    if any(shape.xyz):
        shape_data["xyz"] = _rounded(shape.xyz, 6)
    if any(shape.rpy):
        shape_data["quat"] = _rounded(quaternion_of(shape.rpy), 9)
    if not shape.contact:
        shape_data["contact"] = False
    if shape.pad:
        shape_data["pad"] = True
    return shape_data


def _piece_data(piece: Piece) -> dict[str, Any]:
    piece_data: dict[str, Any] = {}
    if piece.tube:
        piece_data["tube"] = _rounded(piece.tube, 5)
        if piece.is_flat:
            piece_data["flat"] = True
    else:
        if piece.mesh is not None:
            piece_data["mesh"] = piece.mesh.packed
        else:
            piece_data["box"] = _rounded(piece.box, 5)
        if piece.edge is not None:
            piece_data["edge"] = round(piece.edge, 5)
        if any(piece.xyz):
            piece_data["xyz"] = _rounded(piece.xyz, 5)
        if any(piece.rpy):
            piece_data["quat"] = _rounded(quaternion_of(piece.rpy), 6)
    if piece.paint:
        piece_data["paint"] = piece.paint
    if piece.is_joint:
        piece_data["joint"] = True
    return piece_data


def _unit(axis: tuple[float, float, float]) -> tuple[float, float, float]:
    length = math.hypot(*axis)
    return axis[0] / length, axis[1] / length, axis[2] / length


def _rounded(values: Iterable[float], digits: int) -> list[float]:
    # The sum turns -0.0 into 0.0.
    return [round(float(value), digits) + 0.0 for value in values]
