"""What the replay draws of each body of a robot: a look made for it, or its shapes with housings.

What is drawn is never simulated, and what is simulated stays with the body: marks of contacts go by
that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tracerisk.common.geometry.rotation import quaternion_of, rotated
from tracerisk.common.geometry.shapes import Shape
from tracerisk.report.html.run.joining import nearest_in, with_joins
from tracerisk.report.html.run.replay_model import Body
from tracerisk.twin.looks.fitting import look_of
from tracerisk.twin.looks.look import Piece
from tracerisk.twin.looks.menagerie import menagerie_meshes
from tracerisk.twin.looks.meshes import own_meshes
from tracerisk.twin.looks.plain_look import housing, piece_of
from tracerisk.twin.robots.robot import Robot

Point = tuple[float, float, float]

_NEAR = 0.5  # a shape holds a joint nearer to it than so much of its radius
_ALONG = 0.7  # cosine of the angle below which a shape goes along an axis


def with_looks(bodies: Sequence[Body], robot: Robot) -> tuple[tuple[Body, ...], str]:
    """Return the bodies, those of the robot with what is drawn of them, and a sentence on it.

    Meshes of the robot's own model come first, then those of mujoco_menagerie where the user names
    its folder, then a shipped look.
    The sentence is empty where there is nothing to say.
    """
    meshes, note = (own, "") if (own := own_meshes(robot)) else menagerie_meshes(robot)
    made = look_of(robot) | meshes
    joined = with_joins(bodies)
    drawn = tuple(
        replace(body, look=made[body.name] if body.name in made else _plain(body, joined))
        if body.kind == "robot"
        else body
        for body in joined
    )
    return drawn, note


def _plain(body: Body, bodies: Sequence[Body]) -> tuple[Piece, ...]:
    pieces = tuple(piece_of(shape) for shape in body.shapes)
    if body.joint != "hinge" or body.element is None:
        return pieces
    own = _holding(body.shapes, (0.0, 0.0, 0.0), body.axis)
    held = own + _holding(bodies[body.parent].shapes, body.xyz, rotated(body.quaternion, body.axis))
    drive = housing(body.axis, [shape for shape, _ in held], any(along for _, along in held))
    return pieces if drive is None else (*pieces, drive)


def _holding(shapes: Sequence[Shape], place: Point, axis: Point) -> list[tuple[Shape, bool]]:
    """Return the shapes that hold a joint at `place`, each with whether it goes along the axis."""
    held = []
    for shape in shapes:
        near = nearest_in(shape, place)
        away = sum((one - other) ** 2 for one, other in zip(near, place, strict=True)) ** 0.5
        radius = min(shape.size) if shape.kind == "box" else shape.size[0]
        if shape.contact and away < _NEAR * radius:
            direction = rotated(quaternion_of(shape.rpy), (0.0, 0.0, 1.0))
            cosine = sum(one * other for one, other in zip(direction, axis, strict=True))
            held.append((shape, shape.kind == "sphere" or abs(cosine) > _ALONG))
    return held
