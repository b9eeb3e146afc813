"""The shapes of a moveit_msgs/CollisionObject as a body of the twin.

Meshes and cones become their convex hulls.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import RobotError
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.moveit.scene.planning_scene import PlanningScene
from tracerisk.ros.transforms.poses import (
    IDENTITY,
    ORIGIN,
    compose,
    inverse,
    multiply,
    quaternion_from_rpy,
    rpy_from_quaternion,
    unit_quaternion,
)
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.physics.scene_body import HalfSpace, Hull, SceneBody

_BOX, _SPHERE, _CYLINDER, _CONE, _PRISM = 1, 2, 3, 4, 5  # shape_msgs/SolidPrimitive
_SIZES = {_BOX: 3, _SPHERE: 1, _CYLINDER: 2, _CONE: 2}
_AROUND = 16  # points on the rim of a cone


def scene_body(
    name: str,
    pose: Pose,
    message: Any,
    *,
    link: str | None = None,
    touch_links: tuple[str, ...] = (),
) -> SceneBody:
    """Return the body that a CollisionObject describes, at `pose` in the world or in `link`.

    Raises:
        RobotError: a shape has no size, is of no known kind, or is a mesh without volume.
    """
    shapes, hulls, grounds = [], [], []
    own = own_pose(message)
    for index, primitive in enumerate(message.primitives):
        place = _place(message.primitive_poses, index, own)
        if primitive.type == _CONE:
            hulls.append(_cone(name, primitive, place))
        else:
            shapes.append(_shape(name, primitive, place))
    for index, mesh in enumerate(message.meshes):
        place = _place(message.mesh_poses, index, own)
        hulls.append(_hull(place, [(v.x, v.y, v.z) for v in mesh.vertices]))
    for index, plane in enumerate(message.planes):
        grounds.append(_half_space(name, plane.coef, _place(message.plane_poses, index, own)))
    return SceneBody(
        name, pose, tuple(shapes), tuple(hulls), tuple(grounds), link=link, touch_links=touch_links
    )


def own_pose(message: Any) -> Pose:
    """Return the pose of which the poses of the shapes must be cleared.

    Objects of the older form have no pose of their own; theirs is that of their first shape.
    """
    return first_pose(message) or ORIGIN


def first_pose(message: Any) -> Pose | None:
    """Return the pose of the first shape of an object that has no pose of its own, else None."""
    poses = [*message.primitive_poses, *message.mesh_poses, *message.plane_poses]
    is_empty = message_pose(message.pose) == message_pose(type(message.pose)())
    return message_pose(poses[0]) if is_empty and poses else None


def _place(poses: Any, index: int, own: Pose) -> Pose:
    if index >= len(poses):
        return ORIGIN
    return compose(inverse(own), message_pose(poses[index]))


def _shape(name: str, primitive: Any, place: Pose) -> Shape:
    rpy = rpy_from_quaternion(place.orientation)
    if primitive.type == _BOX:
        x, y, z = _sizes(name, primitive)
        return Shape("box", (x / 2, y / 2, z / 2), place.position, rpy)
    if primitive.type == _SPHERE:
        return Shape("sphere", tuple(_sizes(name, primitive)), place.position, rpy)
    if primitive.type == _CYLINDER:
        height, radius = _sizes(name, primitive)
        return Shape("cylinder", (radius, height / 2), place.position, rpy)
    text = "a prism" if primitive.type == _PRISM else f"of type {primitive.type}"
    raise RobotError(
        f"a shape of object '{name}' is {text}; give a box (1), sphere (2), cylinder (3), "
        "cone (4), or a mesh"
    )


def _cone(name: str, primitive: Any, place: Pose) -> Hull:
    height, radius = _sizes(name, primitive)
    turns = [2 * math.pi * k / _AROUND for k in range(_AROUND)]
    rim = [(radius * math.cos(a), radius * math.sin(a), -height / 2) for a in turns]
    return _hull(place, [*rim, (0.0, 0.0, height / 2)])


def _hull(place: Pose, points: list[tuple[float, float, float]]) -> Hull:
    return Hull(tuple(compose(place, Pose(point, IDENTITY)).position for point in points))


def _half_space(name: str, coefficients: Any, place: Pose) -> HalfSpace:
    a, b, c, d = (float(value) for value in coefficients)
    length = math.sqrt(a * a + b * b + c * c)
    if not math.isfinite(length + d) or length < 1e-9:
        raise RobotError(f"the plane of object '{name}' has no normal; give ax + by + cz + d = 0")
    normal = (a / length, b / length, c / length)
    # The turn that brings z onto the normal: half way between both, by half a turn.
    x, y, z = normal
    turn = (
        quaternion_from_rpy(math.pi, 0.0, 0.0)
        if z < -1.0 + 1e-9
        else unit_quaternion((-y, x, 0.0, 1.0 + z))
    )
    at = (-d / length * x, -d / length * y, -d / length * z)
    on_plane = compose(place, Pose(at, IDENTITY))
    return HalfSpace(Pose(on_plane.position, multiply(place.orientation, turn)))


def _sizes(name: str, primitive: Any) -> list[float]:
    sizes = [float(value) for value in primitive.dimensions]
    wanted = _SIZES[primitive.type]
    if len(sizes) != wanted or not all(math.isfinite(size) and size > 0.0 for size in sizes):
        raise RobotError(
            f"a shape of object '{name}' has the dimensions {sizes}; "
            f"its type {primitive.type} takes {wanted} lengths above 0"
        )
    return sizes


def scene_bodies(scene: PlanningScene, report: Callable[[str], None]) -> list[SceneBody]:
    """Return the objects of a scene as bodies of the twin; one that cannot be is reported."""
    bodies = []
    placed = [(item, None, ()) for item in scene.world.values()] + [
        (one.object, one.link, one.touch_links) for one in scene.attached.values()
    ]
    for item, link, touch_links in placed:
        try:
            bodies.append(
                scene_body(item.name, item.pose, item.message, link=link, touch_links=touch_links)
            )
        except RobotError as error:
            report(f"object '{item.name}' is not a body of the simulation: {error.message}")
    return [one for one in bodies if one.is_solid]
