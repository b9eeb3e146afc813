"""Where a gripper closed, and what stood nearest to it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tracerisk.geometry.frames import Matrix, about, rotation
from tracerisk.twin.recording.samples import POSE_EVERY, Samples

if TYPE_CHECKING:
    from tracerisk.twin.physics.scene import Scene
    from tracerisk.twin.robots.robot import Gripper, Robot

Point = tuple[float, float, float]


def grasp_place(
    robot: Robot, gripper: Gripper, scene: Scene, samples: Samples, time_ns: int
) -> str:
    """Return where the middle between a gripper's pads was, and what stood nearest, in words.

    Places are those of the scene, as the objects of a scenario have them; distances are to the
    origins of things that can be moved. Empty where the samples do not reach.
    """
    step = time_ns // samples.header.step_ns
    if not 0 <= step < samples.n_steps:
        return ""
    at = dict(zip(samples.header.joints, samples.position[step].tolist(), strict=True))
    place = between_pads(robot, gripper, at, scene)
    words = f"at ({', '.join(_millimetres(each) for each in place)}) m"
    things = _things(samples, step)
    if not things:
        return words
    name, far = min(
        ((name, math.dist(place, where)) for name, where in things.items()),
        key=lambda each: each[1],
    )
    return f"{words}, {_millimetres(far)} m from {name}, the nearest object"


def between_pads(robot: Robot, gripper: Gripper, at: Mapping[str, float], scene: Scene) -> Point:
    """Return the middle between a gripper's pads [m] for positions of the joints, in the scene."""
    links = {each.name: each for each in robot.links}
    pads = []
    for name in gripper.pads:
        marked = [shape.xyz for shape in links[name].shapes if shape.pad] or [(0.0, 0.0, 0.0)]
        pads.append(_in_base(robot, name, np.mean(marked, axis=0), at))
    middle = rotation(scene.robot_rpy) @ np.mean(pads, axis=0) + scene.robot_xyz
    return float(middle[0]), float(middle[1]), float(middle[2])


def _in_base(robot: Robot, link: str, point: Matrix, at: Mapping[str, float]) -> Matrix:
    """Return a point of a link as the robot's base sees it."""
    for joint in robot.above(link):
        position = at.get(joint.name, 0.0)
        if joint.type == "prismatic":
            axis = np.asarray(joint.axis)
            point = point + position * axis / np.linalg.norm(axis)
        elif joint.type != "fixed":
            point = about(joint.axis, position) @ point
        point = rotation(joint.rpy) @ point + joint.xyz
    return point


def _things(samples: Samples, step: int) -> dict[str, Point]:
    """Return where each thing that can be moved was, at the pose before a step."""
    header = samples.header
    if not len(samples.poses):
        return {}
    pose = samples.poses[min(step // POSE_EVERY, len(samples.poses) - 1)]
    return {
        name: (float(pose[start]), float(pose[start + 1]), float(pose[start + 2]))
        for name, start in zip(header.free_bodies, header.free_at, strict=True)
    }


def _millimetres(length: float) -> str:
    return f"{round(length, 3) + 0.0:.3f}"
