"""The meshes of a robot's model as its look, and those of another model of the same robot."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import roll_pitch_yaw, rotation, triple
from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.looks.look import Piece, is_called
from tracerisk.twin.robots.robot import Robot

Matrix = NDArray[np.float64]

_OFF_M = 5e-3  # how far the axes of two models of one robot may be apart
_TURNED = 0.02  # sine of the angle by which they may be


def own_meshes(robot: Robot) -> dict[str, tuple[Piece, ...]]:
    """Return the meshes of a robot's links as pieces, by the names of the links."""
    return {
        link.name: tuple(_piece(shape, np.eye(4)) for shape in link.drawn)
        for link in robot.links
        if link.drawn
    }


def meshes_of_model(robot: Robot, model: Robot) -> dict[str, tuple[Piece, ...]]:
    """Return the meshes of another model of a robot, each on the link that moves with it.

    Where the axes of the two are not the same with all joints at zero, nothing is returned.
    """
    ours, theirs = _poses(robot), _poses(model)
    joints = [joint.name for joint in robot.arm_joints]
    others = [joint.name for joint in model.arm_joints][: len(joints)]
    if len(others) < len(joints):
        return {}
    onto = _onto(
        [_axis(robot, name, ours) for name in joints],
        [_axis(model, name, theirs) for name in others],
    )
    if onto is None:
        return {}
    moving = dict(zip(others, joints, strict=True))
    pieces: dict[str, tuple[Piece, ...]] = {}
    for link in model.links:
        name = _moved_by(model, link.name)
        # Fingers may stand elsewhere: each model opens its gripper in its own way.
        if not link.drawn or (name is not None and name not in moving):
            continue
        place = _link_for(robot, link.name, None if name is None else moving[name])
        frame = np.linalg.inv(ours[place]) @ onto @ theirs[link.name]
        pieces[place] = (*pieces.get(place, ()), *(_piece(shape, frame) for shape in link.drawn))
    return pieces


def _piece(shape: Shape, frame: Matrix) -> Piece:
    """Return a mesh as a piece, moved by `frame` (4, 4)."""
    assert shape.mesh is not None, "what is drawn of a link has a mesh"
    turn, place = frame[:3, :3], frame[:3, 3]
    return Piece(
        mesh=shape.mesh,
        xyz=triple(place + turn @ np.array(shape.xyz)),
        rpy=roll_pitch_yaw(turn @ rotation(shape.rpy)),
        paint=shape.mesh.paint,
    )


def _poses(robot: Robot) -> dict[str, Matrix]:
    """Return the frame of each link with all joints at zero, (4, 4), in the base's."""
    poses: dict[str, Matrix] = {robot.base_link: np.eye(4)}
    waiting = list(robot.attachments)
    while waiting:
        left = []
        for hung in waiting:
            if hung.parent not in poses:
                left.append(hung)
                continue
            step = np.eye(4)
            step[:3, :3], step[:3, 3] = rotation(hung.rpy), hung.xyz
            poses[hung.child] = poses[hung.parent] @ step
        waiting = left
    return poses


def _axis(robot: Robot, joint: str, poses: Mapping[str, Matrix]) -> tuple[Matrix, Matrix]:
    """Return a point on the axis of a joint and its direction, (3,) each."""
    attachment = next(hung for hung in robot.attachments if hung.name == joint)
    pose = poses[attachment.child]
    direction = pose[:3, :3] @ np.array(attachment.axis)
    return pose[:3, 3], direction / np.linalg.norm(direction)


def _onto(ours: list[tuple[Matrix, Matrix]], theirs: list[tuple[Matrix, Matrix]]) -> Matrix | None:
    """Return the transform (4, 4) that brings their axes onto ours; `None` where none does.

    Bases may be turned by quarters, and may stand in different places.
    """
    for quarter in range(4):
        turn = rotation((0.0, 0.0, quarter * np.pi / 2))
        rows, right = [], []
        for (point, axis), (other, direction) in zip(ours, theirs, strict=True):
            if np.linalg.norm(np.cross(axis, turn @ direction)) > _TURNED:
                break
            across = np.eye(3) - np.outer(axis, axis)
            rows.append(across)
            right.append(across @ (point - turn @ other))
        else:
            shift = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
            off = np.vstack(rows) @ shift - np.concatenate(right)
            if np.linalg.norm(off.reshape(-1, 3), axis=1).max() < _OFF_M:
                onto = np.eye(4)
                onto[:3, :3], onto[:3, 3] = turn, shift
                return onto
    return None


def _moved_by(robot: Robot, link: str) -> str | None:
    """Return the joint that moves a link against what stands; `None` for the base."""
    names = {joint.name for joint in robot.joints}
    return next((hung.name for hung in robot.above(link) if hung.name in names), None)


def _link_for(robot: Robot, name: str, joint: str | None) -> str:
    """Return the link that a mesh belongs to, of those that move with it.

    It is one that has shapes, whose place the mesh takes: the one named alike, else the first.
    """
    together = [link for link in robot.links if _moved_by(robot, link.name) == joint]
    solid = [link.name for link in together if link.shapes] or [link.name for link in together]
    alike = [link for link in solid if is_called(link, name)]
    return (alike or solid)[0]
