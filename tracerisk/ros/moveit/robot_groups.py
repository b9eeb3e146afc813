"""What move_group knows of a robot by itself: its groups, their links and joint targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import takewhile
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from tracerisk.twin.robots.robot import Robot
    from tracerisk.twin.robots.robot_parts import Gripper, Group, Joint

_MOST_DRAWS = 100  # until a random position is clear of collisions


class RobotGroups:
    """The planning groups of a robot; what is drawn comes from a generator begun with `seed`."""

    def __init__(self, robot: Robot, seed: int) -> None:
        self.robot = robot
        self.random = np.random.default_rng(seed)

    @property
    def planning_frame(self) -> str:
        """The frame in which plans are made: the robot's base link."""
        return self.robot.base_link

    def group(self, name: str) -> Group:
        """Return a planning group.

        Raises:
            RobotError: the robot has no such group; lists those it has.
        """
        return self.robot.group(name)

    def gripper_of(self, name: str) -> Gripper | None:
        """Return the gripper whose fingers are all that the group moves, else None."""
        joints = set(self.group(name).joints)
        return next((one for one in self.robot.grippers if joints <= set(one.joints)), None)

    def variables(self, name: str) -> tuple[str, ...]:
        """Return the joints of a group that have a value, with those that follow another."""
        group = self.group(name)
        moving = {joint.name for joint in self.robot.joints}
        return tuple(one for one in group.members if one in moving) or group.joints

    def group_joints(self, name: str) -> tuple[str, ...]:
        """Return all joints of a group, with those that are fixed or follow another."""
        group, links = self.group(name), self.group_links(name)
        return group.members or tuple(
            one.name for one in self.robot.attachments if one.child in links
        )

    def active_joints(self, name: str) -> tuple[str, ...]:
        """Return the joints of a group that follow no other one in it."""
        group = self.group(name)
        follows = {
            one
            for gripper in self.robot.grippers
            for one in gripper.joints[1:]
            if gripper.joints[0] in group.joints
        }
        driven = set(group.joints) - follows
        return tuple(one for one in self.variables(name) if one in driven)

    def values_by_name(self, name: str, values: Sequence[float]) -> dict[str, float] | None:
        """Return a list of values by the joints of a group, `None` where it is of another length.

        It has a value for each joint that follows another, too, which is not used. Where nobody
        says which of a gripper's fingers are in its group, it may be that of all or of the first.
        """
        group = self.group(name)
        gripper = self.gripper_of(name)
        listed = self.variables(name)
        if gripper is not None and not group.members and len(values) != len(listed):
            listed = tuple(one.name for one in self.robot.joints if one.name in gripper.joints)
        if len(values) != len(listed):
            return None
        given = dict(zip(listed, values, strict=True))
        return {joint: given[joint] for joint in group.joints}

    def end_effector_link(self, name: str) -> str:
        """Return the tip of a group that is an arm, else the empty string."""
        group = self.group(name)
        return group.tip_link if group.tip_link and self.gripper_of(name) is None else ""

    def group_links(self, name: str) -> tuple[str, ...]:
        """Return the links that the group's joints carry, from the base to the tip.

        Links of fixed joints belong to the group as far as they lie on the way to its tip.
        """
        group = self.group(name)
        way = {one.child for one in self.robot.above(group.tip_link or "")}
        moved = {one.child for one in self.robot.attachments if one.name in group.joints}
        first = min((self.robot.link_names.index(link) for link in moved), default=0)
        return tuple(
            link
            for index, link in enumerate(self.robot.link_names)
            if link in moved or (link in way and index > first)
        )

    def hand_links(self, tip: str) -> tuple[str, ...]:
        """Return the links that move with a tip, and those beyond them: hand and fingers."""
        rigid = takewhile(lambda one: one.type == "fixed", self.robot.above(tip))
        *_, root = (tip, *(one.parent for one in rigid))
        return tuple(
            link
            for link in self.robot.link_names
            if link == root or any(one.parent == root for one in self.robot.above(link))
        )

    def default_target(self, name: str) -> dict[str, float]:
        """Return a new client's joint target: zero, or the middle where zero is out of limits."""
        target = {}
        for joint in map(self.robot.joint, self.group(name).joints):
            middle = (joint.lower + joint.upper) / 2
            target[joint.name] = 0.0 if joint.lower <= 0.0 <= joint.upper else middle
        return target

    def random_target(self, name: str) -> dict[str, float]:
        """Return joint positions drawn evenly within the group's limits, clear of collisions."""
        return self._drawn([*map(self.robot.joint, self.group(name).joints)])

    def random_positions(self) -> dict[str, float]:
        """Return a position of every joint, drawn evenly within its limits, clear of collisions."""
        return self._drawn(self.robot.joints)

    def is_clear(self, positions: Mapping[str, float]) -> bool:
        """Return whether the robot touches nothing that plans keep clear of; here nothing is known.

        Joints that `positions` leaves out are as they are.
        """
        del positions
        return True

    def _drawn(self, joints: Sequence[Joint]) -> dict[str, float]:
        # What is drawn is chance; a goal in collision would say more of the seed than of the code.
        for _ in range(_MOST_DRAWS):
            drawn = {one.name: float(self.random.uniform(one.lower, one.upper)) for one in joints}
            if self.is_clear(drawn):
                break
        return drawn
