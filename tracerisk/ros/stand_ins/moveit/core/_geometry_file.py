"""The .scene files in which MoveIt keeps the objects of a world.

The form is that of planning_scene.cpp of moveit/moveit2 and shape_operations.cpp of
moveit/geometric_shapes: a name, then for each object `* id`, its pose, and its shapes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from tracerisk.ros.moveit.messages import set_pose
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.moveit.scene.planning_scene import PlanningScene as Objects
from tracerisk.ros.moveit.scene.planning_scene import SceneObject
from tracerisk.ros.moveit.scene.shapes import own_pose
from tracerisk.ros.transforms.poses import compose, inverse, unit_quaternion
from tracerisk.twin.physics.motion import Pose

from .._library import new

# shape_msgs/SolidPrimitive; a cylinder and a cone are written with the radius first.
_NAMES = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone"}
_SIZES = {"box": 3, "sphere": 1, "cylinder": 2, "cone": 2}


def write_geometry(file: str, name: str, objects: Objects) -> bool:
    """Write the objects of a world; False where the file cannot be written."""
    lines = [name]
    for _, item in sorted(objects.world.items()):
        lines += [f"* {item.name}", *_pose_lines(item.pose), *_shape_lines(item), "0"]
    try:
        Path(file).write_text("\n".join([*lines, "."]) + "\n", encoding="utf-8")
    except OSError:
        return False
    return True


def read_geometry(file: str, frame: str) -> list[Any]:
    """Return the objects of a file as CollisionObjects in a frame; none where it cannot be read.

    Raises:
        RuntimeError: the file is no .scene file.
    """
    try:
        text = Path(file).read_text(encoding="utf-8")
    except OSError:
        return []
    _, _, rest = text.partition("\n")
    words = iter(rest.split())
    try:
        return list(_objects(words, frame))
    except (RuntimeError, ValueError) as error:
        # A text that ends too early stops the generator's words, which is a RuntimeError.
        reason = str(error) if isinstance(error, ValueError) else "it ends too early"
        raise RuntimeError(f"{file} is no .scene file: {reason}") from error


def _objects(words: Iterator[str], frame: str) -> Iterator[Any]:
    for mark in words:
        if mark == ".":
            return
        if mark != "*":
            raise ValueError(f"'{mark}' stands where an object begins; allowed: '*' and '.'")
        message = new("moveit_msgs/CollisionObject")
        message.id, message.header.frame_id = next(words), frame
        pose = _read_pose(words)
        set_pose(message.pose, pose)
        for _ in range(int(next(words))):
            _read_shape(words, message)
        for _ in range(int(next(words))):
            next(words)
            _read_pose(words)
        yield message


def _read_shape(words: Iterator[str], message: Any) -> None:
    kind = next(words)
    place = new("geometry_msgs/Pose")
    if kind == "plane":
        plane = new("shape_msgs/Plane")
        plane.coef = _numbers(words, 4)
        set_pose(place, _read_pose(words))
        message.planes = [*message.planes, plane]
        message.plane_poses = [*message.plane_poses, place]
    elif kind == "mesh":
        mesh = _read_mesh(words)
        set_pose(place, _read_pose(words))
        message.meshes = [*message.meshes, mesh]
        message.mesh_poses = [*message.mesh_poses, place]
    elif kind in _SIZES:
        solid = new("shape_msgs/SolidPrimitive")
        solid.type = next(number for number, name in _NAMES.items() if name == kind)
        sizes = _numbers(words, _SIZES[kind])
        solid.dimensions = sizes if kind in ("box", "sphere") else sizes[::-1]
        set_pose(place, _read_pose(words))
        message.primitives = [*message.primitives, solid]
        message.primitive_poses = [*message.primitive_poses, place]
    else:
        raise ValueError(
            f"'{kind}' is not a shape; allowed: {', '.join([*_SIZES, 'plane', 'mesh'])}"
        )
    _numbers(words, 4)  # the colour


def _read_mesh(words: Iterator[str]) -> Any:
    mesh = new("shape_msgs/Mesh")
    n_vertices, n_triangles = int(next(words)), int(next(words))
    for _ in range(n_vertices):
        point = new("geometry_msgs/Point")
        point.x, point.y, point.z = _numbers(words, 3)
        mesh.vertices.append(point)
    for _ in range(n_triangles):
        triangle = new("shape_msgs/MeshTriangle")
        triangle.vertex_indices = [int(next(words)) for _ in range(3)]
        mesh.triangles.append(triangle)
    return mesh


def _read_pose(words: Iterator[str]) -> Pose:
    x, y, z, *turn = _numbers(words, 7)
    return Pose((x, y, z), unit_quaternion(turn))


def _numbers(words: Iterator[str], count: int) -> list[float]:
    return [float(next(words)) for _ in range(count)]


def _shape_lines(item: SceneObject) -> list[str]:
    message, back = item.message, inverse(own_pose(item.message))
    shapes: list[list[str]] = []
    for solid, place in zip(message.primitives, message.primitive_poses, strict=False):
        sizes = [float(value) for value in solid.dimensions]
        name = _NAMES[int(solid.type)]
        ordered = sizes if name in ("box", "sphere") else sizes[::-1]
        shapes.append([name, _row(ordered), *_pose_lines(compose(back, message_pose(place)))])
    for mesh, place in zip(message.meshes, message.mesh_poses, strict=False):
        rows = [_row((p.x, p.y, p.z)) for p in mesh.vertices]
        rows += [" ".join(str(int(i)) for i in one.vertex_indices) for one in mesh.triangles]
        counts = f"{len(mesh.vertices)} {len(mesh.triangles)}"
        shapes.append(["mesh", counts, *rows, *_pose_lines(compose(back, message_pose(place)))])
    for plane, place in zip(message.planes, message.plane_poses, strict=False):
        pose = _pose_lines(compose(back, message_pose(place)))
        shapes.append(["plane", _row([float(value) for value in plane.coef]), *pose])
    colour = "0 0 0 0"
    return [str(len(shapes)), *(line for shape in shapes for line in [*shape, colour])]


def _pose_lines(pose: Pose) -> list[str]:
    return [_row(pose.position), _row(pose.orientation)]


def _row(values: Sequence[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)
