"""Where position and orientation constraints of moveit_msgs allow a link to be."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tracerisk.ros.moveit.path_constraints import BOX, CYLINDER, SPHERE, is_within, message_pose
from tracerisk.ros.moveit.plan_records import PoseGoal
from tracerisk.ros.transforms.poses import (
    ORIGIN,
    Quaternion,
    Vector,
    compose,
    goal_quaternion,
    multiply,
    quaternion_from_rpy,
    rotate,
    unit_quaternion,
)
from tracerisk.twin.physics.motion import Pose

_NEAR, _NEAR_TURN = 1e-4, 1e-3  # [m], [rad]: a link is this near its goal at the least
_NARROW, _NARROW_TURN = 0.05, 0.1  # [m], [rad]: no other sample is reached where one is not
_TRIES = 200  # for a point within several regions


@dataclass(frozen=True, slots=True, eq=False)
class LinkRegion:
    """Where a link may be; all of its constraints hold, each with the pose of its frame."""

    link: str
    """The link."""
    positions: tuple[tuple[Any, Pose], ...]
    """Its position constraints."""
    turns: tuple[tuple[Any, Pose], ...]
    """Its orientation constraints."""
    here: Pose
    """Where it is now: what is free stays near."""

    @property
    def is_wide(self) -> bool:
        """Whether there is more than its middle to try."""
        if max(len(self.positions), len(self.turns)) > 1:
            return True
        if self.turns and max(_tolerances(self._turn()[0])) > _NARROW_TURN:
            return True
        if not self.positions:
            return False
        one, _ = self._position()
        offset = one.target_point_offset
        needs_turn = not self.turns and any((offset.x, offset.y, offset.z))
        return needs_turn or _size(one) > _NARROW

    def samples(self) -> Iterator[PoseGoal]:
        """Yield poses of the link without end: the middle of what is allowed, then others.

        There are none where no point is found that is in all its regions.
        """
        generator = np.random.default_rng(0)
        is_first = True
        while True:
            turn = self._sampled_turn(generator, is_first=is_first)
            if not self.positions:
                tolerance = max(min(_tolerances(self._turn()[0])), _NEAR_TURN)
                pose = Pose(ORIGIN.position, turn)
                yield PoseGoal(self.link, pose, "orientation", orientation_tolerance=tolerance)
            else:
                point = self._sampled_point(generator, is_first=is_first)
                if point is None:
                    return
                yield self._goal(point, turn)
            is_first = False

    def _goal(self, point: Vector, turn: Quaternion) -> PoseGoal:
        one, _ = self._position()
        offset = one.target_point_offset
        away = (float(offset.x), float(offset.y), float(offset.z))
        a, b, c = rotate(turn, away)
        pose = Pose((point[0] - a, point[1] - b, point[2] - c), turn)
        near = max(_size(one) / 2, _NEAR)
        if not self.turns:
            # A point off the link's origin is brought somewhere by a turn of the link, too.
            return PoseGoal(self.link, pose, "pose" if any(away) else "position", near)
        turned = max(min(_tolerances(self._turn()[0])), _NEAR_TURN)
        return PoseGoal(self.link, pose, "pose", near, turned)

    def _position(self) -> tuple[Any, Pose]:
        """Return the position constraint that leaves least room."""
        return min(self.positions, key=lambda position: _size(position[0]))

    def _turn(self) -> tuple[Any, Pose]:
        """Return the orientation constraint that leaves least room."""
        return min(self.turns, key=lambda turn: sum(_tolerances(turn[0])))

    def _sampled_turn(self, generator: np.random.Generator, *, is_first: bool) -> Quaternion:
        if not self.turns:
            if is_first:
                return self.here.orientation
            x, y, z, w = generator.normal(size=4).tolist()
            return unit_quaternion((x, y, z, w))
        one, frame = self._turn()
        q = one.orientation
        middle = multiply(frame.orientation, goal_quaternion((q.x, q.y, q.z, q.w)))
        if is_first:
            return middle
        limits = [min(tolerance, math.pi) for tolerance in _tolerances(one)]
        roll, pitch, yaw = (0.9 * generator.uniform(-limit, limit) for limit in limits)
        return multiply(middle, quaternion_from_rpy(roll, pitch, yaw))

    def _sampled_point(self, generator: np.random.Generator, *, is_first: bool) -> Vector | None:
        one, frame = self._position()
        region = one.constraint_region
        shapes = list(zip(region.primitives, region.primitive_poses, strict=False))
        for number in range(_TRIES):
            # One without a shape is its place alone.
            shape, place = None, region.primitive_poses[0]
            if shapes:
                shape, place = shapes[int(generator.integers(len(shapes)))]
            if is_first and number < len(shapes):
                shape, place = None, shapes[number][1]
            seen = (0.0, 0.0, 0.0) if shape is None else _inside(shape, generator)
            there = compose(compose(frame, message_pose(place)), Pose(seen, ORIGIN.orientation))
            others = [position for position in self.positions if position[0] is not one]
            if all(is_within(other, base, there.position) for other, base in others):
                return there.position
        return None


def _tolerances(one: Any) -> list[float]:
    return [float(getattr(one, f"absolute_{axis}_axis_tolerance")) for axis in "xyz"]


def _size(one: Any) -> float:
    """Return the least size of the region of a position constraint [m]."""
    sizes = [float(size) for shape in one.constraint_region.primitives for size in shape.dimensions]
    return min(sizes, default=0.0)


def _inside(shape: Any, generator: np.random.Generator) -> Vector:
    """Return a point in a shape, as seen from its middle; of other shapes, the middle."""
    sizes = [float(size) for size in shape.dimensions]
    if shape.type == BOX:
        x, y, z = (generator.uniform(-size / 2, size / 2) for size in sizes)
        return x, y, z
    if shape.type == SPHERE:
        x, y, z = generator.normal(size=3).tolist()
        share = sizes[0] * generator.uniform() ** (1 / 3) / max(math.hypot(x, y, z), 1e-9)
        return x * share, y * share, z * share
    if shape.type == CYLINDER:
        angle = generator.uniform(-math.pi, math.pi)
        radius = sizes[1] * math.sqrt(generator.uniform())
        height = generator.uniform(-sizes[0] / 2, sizes[0] / 2)
        return radius * math.cos(angle), radius * math.sin(angle), height
    return 0.0, 0.0, 0.0
