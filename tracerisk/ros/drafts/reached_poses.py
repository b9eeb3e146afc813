"""What the arm of a robot reaches: joints, a posture, and poses in front of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property

from tracerisk.ros.drafts.named_numbers import Reach
from tracerisk.ros.drafts.posture_numbers import roll_pitch_yaw
from tracerisk.ros.transforms.poses import compose, inverse
from tracerisk.twin.physics.motion import PlanningError, Pose
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Group, Joint

_NO_TURN = (0.0, 0.0, 0.0, 1.0)
_STEP = 0.2  # how far from where it is a joint is sent [rad; of its range where it slides]
_TRIED = 400  # postures among which one with the tool in front of the arm is looked for
_ABOVE = ((0.2, 8), (0.1, 24))
"""From how far above a pose is approached [m], and for how many of the best that is tried."""
_AHEAD = 0.4  # of the arm's reach: how far before its base a pose should be
_HEIGHT = 0.15  # of its reach: how high above the base's foot
_APART = 0.1  # poses are so far apart [m]
_POSES = 3  # a pose and the others that may be tried for it
_UPRIGHT = 0.1  # 1 - cosine between an axis of the tool and straight down
_HALTON = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29)
BOX = (0.04, 0.04, 0.1)
"""A thing that a gripper can hold [m]."""


class ReachedPoses:
    """The poses and the posture that stand in for those that only the author knows.

    `forward` gives the pose of a link for joint positions, `inverse` the positions of a group
    that bring its tip to a pose, free of collisions (PlanningError: none do). Within `alone` these
    are collisions of the robot with itself: what is in the scene may stand where it is to come.
    """

    def __init__(
        self,
        robot: Robot,
        forward: Callable[[Mapping[str, float], str], Pose],
        inverse: Callable[[str, Pose], Mapping[str, float]],
        alone: Callable[[], AbstractContextManager[None]] = nullcontext,
    ) -> None:
        self.robot = robot
        self._forward = forward
        self._solve = inverse
        self._alone = alone
        self._number = 0

    @cached_property
    def group(self) -> tuple[str, Group] | None:
        """The group of the arm: the one with most joints of those that have a tip."""
        groups = [
            (name, group)
            for name, group in self.robot.groups.items()
            if group.tip_link is not None and group.joints
        ]
        arms = {joint.name for joint in self.robot.arm_joints}
        return max(groups, key=lambda pair: len(arms & set(pair[1].joints)), default=None)

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joints of the arm, in the order of its group."""
        if self.group is not None:
            return tuple(self.robot.joint(name) for name in self.group[1].joints)
        return self.robot.arm_joints

    @cached_property
    def posture(self) -> tuple[float, ...]:
        """A position of each joint of the arm [rad or m], a little away from where it begins."""
        return tuple(self._moved(joint) for joint in self.joints)

    def _moved(self, joint: Joint) -> float:
        now = self.robot.initial_state.get(joint.name, 0.0)
        if not math.isfinite(joint.lower) or not math.isfinite(joint.upper):
            return round(now + _STEP, 3)
        step = _STEP * (joint.upper - joint.lower) if joint.type == "prismatic" else _STEP
        towards = now + math.copysign(step, (joint.lower + joint.upper) / 2 - now)
        return round(min(max(towards, joint.lower), joint.upper), 3)

    @property
    def pose(self) -> Pose:
        """A pose in the base link's frame that the tool reaches, and from above too."""
        return self.poses[min(self._number, len(self.poses) - 1)]

    @cached_property
    def poses(self) -> tuple[Pose, ...]:
        """Poses that the tool reaches, the one nearest to where an arm works first."""
        with self._alone():
            result = list(self._reachable())
        return tuple(result) or (Pose((0.3, 0.0, 0.3), (0.0, 0.0, 0.0, 1.0)),)

    @property
    def reach(self) -> Reach:
        """The pose and the posture, as plain numbers."""
        turn = tuple(round(value, 4) + 0.0 for value in roll_pitch_yaw(self.pose.orientation))
        return Reach(tuple(self.pose.position), turn, self.posture)

    @cached_property
    def start(self) -> Mapping[str, float]:
        """Positions of the arm's joints [rad or m] with its tool at the pose; empty for none."""
        if self.group is None:
            return {}
        try:
            with self._alone():
                solved = self._solve(self.group[0], self.pose)
        except PlanningError:
            return {}
        return {joint.name: round(_unwound(joint, solved[joint.name]), 3) for joint in self.joints}

    @cached_property
    def hand(self) -> tuple[str, tuple[float, ...]] | None:
        """The tip of the arm, and where its gripper holds a thing, in the frame of that link."""
        if self.group is None or self.group[1].tip_link is None:
            return None
        tip, state = self.group[1].tip_link, dict(self.robot.initial_state)
        fingers = [pad for gripper in self.robot.grippers[:1] for pad in gripper.pads]
        places = [
            compose(self._forward(state, link.name), Pose(shape.xyz, _NO_TURN)).position
            for link in self.robot.links
            if link.name in fingers
            for shape in link.shapes
            if shape.pad
        ]
        if not places:
            return tip, (0.0, 0.0, BOX[2])
        x, y, z = (sum(axis) / len(places) for axis in zip(*places, strict=True))
        seen = inverse(self._forward(state, tip))
        middle = compose(seen, Pose((x, y, z), _NO_TURN))
        return tip, tuple(round(value, 3) + 0.0 for value in middle.position)

    def _reachable(self) -> Iterator[Pose]:
        if self.group is None or self.group[1].tip_link is None:
            return
        name, tip = self.group[0], self.group[1].tip_link
        states = [
            {**self.robot.initial_state, **state}
            for state in self.robot.named_states.get(name, {}).values()
        ]
        postures = [dict(self.robot.initial_state), *states, *self._postures()]
        poses = [self._forward(posture, tip) for posture in postures]
        reach = max(math.dist(item.position, (0.0, 0.0, 0.0)) for item in poses)
        ranked = sorted(poses, key=lambda item: _badness(item, reach))
        # The orientation of a known state is one that its author works with.
        upright = min(poses[: 1 + len(states)], key=_tilt)
        result: list[Pose] = []
        tried = ((above, item) for above, most in _ABOVE for item in ranked[:most])
        for above, item in tried:
            if any(math.dist(item.position, other.position) < _APART for other in result):
                continue
            orientations = [item.orientation]
            if _tilt(upright) < _UPRIGHT:
                orientations.insert(0, upright.orientation)
            made = (_rounded(Pose(item.position, orientation)) for orientation in orientations)
            reached = next((pose for pose in made if self._is_reached(name, pose, above)), None)
            if reached is not None:
                result.append(reached)
                yield reached
            if len(result) == _POSES:
                return

    def _is_reached(self, group: str, pose: Pose, above: float) -> bool:
        x, y, z = pose.position
        try:
            self._solve(group, pose)
            self._solve(group, Pose((x, y, z + above), pose.orientation))
        except PlanningError:
            return False
        return True

    def _postures(self) -> Iterator[dict[str, float]]:
        """Yield postures spread evenly over the middle of the joints' ranges."""
        for number in range(1, _TRIED + 1):
            yield {
                joint.name: _within(joint, _halton(number, _HALTON[index % len(_HALTON)]))
                for index, joint in enumerate(self.joints)
            }


def _unwound(joint: Joint, value: float) -> float:
    """Return the position of a turning joint within half a turn of 0, where its limits allow."""
    near = math.remainder(value, math.tau)
    return near if joint.type != "prismatic" and joint.lower <= near <= joint.upper else value


def _badness(pose: Pose, reach: float) -> float:
    """Return how far a pose is from where an arm works: before it, and above its foot [m]."""
    return round(math.dist(pose.position, (_AHEAD * reach, 0.0, _HEIGHT * reach)), 3)


def _tilt(pose: Pose) -> float:
    """Return how far the nearest axis of a pose is from pointing straight down [1 - cosine]."""
    x, y, z, w = pose.orientation
    row = (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
    return 1.0 - max(abs(value) for value in row)


def _rounded(pose: Pose) -> Pose:
    x, y, z = (round(value, 3) + 0.0 for value in pose.position)
    a, b, c, d = (round(value, 5) + 0.0 for value in pose.orientation)
    return Pose((x, y, z), (a, b, c, d))


def _halton(number: int, base: int) -> float:
    value, part = 0.0, 1.0
    while number:
        part /= base
        number, digit = divmod(number, base)
        value += digit * part
    return value


def _within(joint: Joint, share: float) -> float:
    lower = joint.lower if math.isfinite(joint.lower) else -math.pi
    upper = joint.upper if math.isfinite(joint.upper) else math.pi
    if joint.type != "prismatic":
        lower, upper = max(lower, -math.pi), min(upper, math.pi)
    return lower + (0.1 + 0.8 * share) * (upper - lower)
