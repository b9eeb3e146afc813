"""Where a gripper closed, and what stood nearest to it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tracerisk.common.geometry.frames import rotation
from tracerisk.twin.recording.samples import POSE_EVERY, SampleHeader, Samples
from tracerisk.twin.robots.gripper_ends import pad_centres, width_at

if TYPE_CHECKING:
    from tracerisk.twin.robots.robot import Robot
    from tracerisk.twin.robots.robot_parts import Gripper

Point = tuple[float, float, float]

_LEAST_OPENING_M = 0.002
"""Pads that are nearer to each other count as closed [m]."""


def grasp_place(
    robot: Robot, gripper: Gripper, samples: Samples, time_ns: int, end_ns: int | None = None
) -> str:
    """Return where the middle between a gripper's pads was, and what stood nearest, in words.

    Also how far apart the pads came to rest, at `end_ns` or at the end of the run.
    Places are those of the scene, as the objects of a scenario have them; distances are to the
    origins of things that can be moved. Empty where the samples do not reach.
    """
    step = time_ns // samples.header.step_ns
    if not 0 <= step < samples.n_steps:
        return ""
    at = dict(zip(samples.header.joints, samples.position[step].tolist(), strict=True))
    place = between_pads(robot, gripper, at, samples.header)
    words = f"at ({', '.join(_millimetres(value) for value in place)}) m"
    if place[2] < 0.0:
        words += ", which is below the floor"
    words += _opening(robot, gripper, samples, end_ns)
    things = _things(samples, step)
    if not things:
        return words
    name, far = min(
        ((name, math.dist(place, where)) for name, where in things.items()),
        key=lambda pair: pair[1],
    )
    return f"{words}, {_millimetres(far)} m from the origin of {name}, the nearest object"


def between_pads(
    robot: Robot, gripper: Gripper, at: Mapping[str, float], header: SampleHeader
) -> Point:
    """Return the middle between a gripper's pads [m] for positions of the joints, in the scene."""
    middle = np.mean(pad_centres(robot, gripper, at), axis=0)
    middle = rotation(header.base_rpy) @ middle + header.base_xyz
    return float(middle[0]), float(middle[1]), float(middle[2])


def _opening(robot: Robot, gripper: Gripper, samples: Samples, end_ns: int | None) -> str:
    """Return how far apart the pads came to rest, in words; empty where they were closed."""
    end = samples.n_steps if end_ns is None else end_ns // samples.header.step_ns
    step = min(end, samples.n_steps - 1)
    at = dict(zip(samples.header.joints, samples.position[step].tolist(), strict=True))
    width = width_at(robot, gripper, gripper.position(at))
    if width < _LEAST_OPENING_M:
        return ""
    return f", its pads {1000.0 * width:.0f} mm apart in the end"


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
