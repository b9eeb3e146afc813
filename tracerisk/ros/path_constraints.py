"""Whether a planned path keeps to moveit_msgs/Constraints."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from tracerisk.ros.poses import compose, conjugate, multiply, rpy_from_quaternion, unit_quaternion
from tracerisk.twin.motion import JointTrajectory, Pose

_BOX, _SPHERE, _CYLINDER = 1, 2, 3  # shape_msgs/SolidPrimitive
_SLACK = 1e-6

Forward = Callable[[Mapping[str, float], str], Pose]
Frame = Callable[[str], Pose | None]


def violation(
    constraints: Any, trajectory: JointTrajectory, forward: Forward, frame: Frame
) -> str | None:
    """Return the first breach of `constraints` on the points of a trajectory, or None.

    `forward(positions, link)` gives a link's pose, `frame(name)` that of a frame, both in the
    planning frame. What cannot be checked counts as a breach, with the reason.
    """
    if constraints.visibility_constraints:
        return "visibility constraints cannot be checked: the twin has no cameras"
    for time, row in zip(trajectory.time, trajectory.position, strict=True):
        positions = dict(zip(trajectory.joints, map(float, row), strict=True))
        for found in _breaches(constraints, positions, forward, frame):
            return f"after {time:.2f} s {found}"
    return None


def _breaches(
    constraints: Any, positions: Mapping[str, float], forward: Forward, frame: Frame
) -> Iterator[str]:
    for one in constraints.joint_constraints:
        value = positions.get(one.joint_name)
        if value is None:
            continue
        low, high = one.position - one.tolerance_below, one.position + one.tolerance_above
        if not low - _SLACK <= value <= high + _SLACK:
            yield f"joint '{one.joint_name}' at {value:.4f} is outside [{low:.4f}, {high:.4f}]"
    for one in constraints.orientation_constraints:
        yield from _orientation_breach(one, positions, forward, frame)
    for one in constraints.position_constraints:
        yield from _position_breach(one, positions, forward, frame)


def _orientation_breach(
    one: Any, positions: Mapping[str, float], forward: Forward, frame: Frame
) -> Iterator[str]:
    base = frame(one.header.frame_id)
    if base is None:
        yield f"an orientation constraint is in the unknown frame '{one.header.frame_id}'"
        return
    q = one.orientation
    wanted = multiply(base.orientation, unit_quaternion((q.x, q.y, q.z, q.w)))
    error = multiply(conjugate(wanted), forward(positions, one.link_name).orientation)
    tolerances = (
        one.absolute_x_axis_tolerance,
        one.absolute_y_axis_tolerance,
        one.absolute_z_axis_tolerance,
    )
    for axis, angle, tolerance in zip("xyz", rpy_from_quaternion(error), tolerances, strict=True):
        if abs(angle) > tolerance + _SLACK:
            yield (
                f"link '{one.link_name}' is turned by {abs(angle):.3f} rad about {axis}, "
                f"{tolerance:.3f} are allowed"
            )


def _position_breach(
    one: Any, positions: Mapping[str, float], forward: Forward, frame: Frame
) -> Iterator[str]:
    base = frame(one.header.frame_id)
    if base is None:
        yield f"a position constraint is in the unknown frame '{one.header.frame_id}'"
        return
    offset = one.target_point_offset
    point = compose(
        forward(positions, one.link_name),
        Pose((offset.x, offset.y, offset.z), (0.0, 0.0, 0.0, 1.0)),
    ).position
    region = one.constraint_region
    if region.meshes:
        yield "a position constraint has a mesh as its region, which cannot be checked"
        return
    for shape, pose in zip(region.primitives, region.primitive_poses, strict=False):
        place = compose(base, message_pose(pose))
        if _is_inside(shape, _seen_from(place, point)):
            return
    yield f"link '{one.link_name}' is outside the region of its position constraint"


def message_pose(message: Any) -> Pose:
    """Return a geometry_msgs/Pose as the twin's; a turn of all zeros is no turn."""
    p, q = message.position, message.orientation
    return Pose((float(p.x), float(p.y), float(p.z)), unit_quaternion((q.x, q.y, q.z, q.w)))


def _seen_from(place: Pose, point: tuple[float, float, float]) -> tuple[float, float, float]:
    back = conjugate(place.orientation)
    px, py, pz = place.position
    moved = Pose((point[0] - px, point[1] - py, point[2] - pz), (0.0, 0.0, 0.0, 1.0))
    return compose(Pose((0.0, 0.0, 0.0), back), moved).position


def _is_inside(shape: Any, point: tuple[float, float, float]) -> bool:
    x, y, z = point
    sizes = [float(value) + _SLACK for value in shape.dimensions]
    if shape.type == _BOX:
        return all(abs(part) <= size / 2 for part, size in zip(point, sizes, strict=True))
    if shape.type == _SPHERE:
        return math.hypot(x, y, z) <= sizes[0]
    if shape.type == _CYLINDER:
        return abs(z) <= sizes[0] / 2 and math.hypot(x, y) <= sizes[1]
    return False
