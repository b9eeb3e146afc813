"""Whether a hold ended because the object slipped out of a gripper that nobody had opened."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import matrix_of, rotation
from tracerisk.common.outcome.arm import tool_pose
from tracerisk.twin.recording.contact_pairs import Hold
from tracerisk.twin.recording.contacts import RunContacts
from tracerisk.twin.recording.samples import POSE_EVERY, Samples
from tracerisk.twin.recording.tool_way import arm_to, tool_places
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.robot_parts import Gripper

LEFT_M = 0.01
"""A hand has left an object when the distance between them changed by more [m].

A few millimetres are an object that was set down, or that the fingers lost for a moment.
"""
_RISE = 0.02  # of its range: a set-point that goes further out opens the gripper
_LEADS = 0.001  # of its range: by how much the set-point of fingers that part is ahead of them
_AROUND_S = 0.5  # a release begins so shortly before or after its hold ends [s]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Slips:
    """What the samples of a run say of the ends of its holds."""

    samples: Samples
    """The samples of the run, with joint positions and controls."""
    contacts: RunContacts
    """The touches and holds of the same run."""

    def has_slipped(self, hold: Hold, poses: Array) -> bool:
        """Return whether an object slipped out of the hand that held it.

        The gripper was not being opened, and the hand left the object before it was opened or
        held the object again. What is merely set down before the gripper opens stays near it.
        poses: (n_poses, 7) of the object.
        """
        gripper = next((g for g in self.contacts.robot.grippers if g.name == hold.holder), None)
        controls = self.samples.header.controls
        if gripper is None or gripper.name not in controls or self._was_detached(hold):
            return False
        opens = self._opening(gripper, hold)
        around = round(_AROUND_S / self.samples.step_s)
        if opens[max(hold.start, hold.stop - around) : hold.stop + around].any():
            return False
        later = np.flatnonzero(opens[hold.stop :])
        until = hold.stop + int(later[0]) if len(later) else self.samples.n_steps
        until = min([until, *(next_hold.start for next_hold in self._next_holds(hold))])
        first, last = (hold.stop - 1) // POSE_EVERY, -(-until // POSE_EVERY)
        apart = self._distances(hold.holder, poses, first, min(last, len(poses)))
        return len(apart) > 0 and bool((np.abs(apart - apart[0]) > LEFT_M).any())

    def turn_between(self, hold: Hold) -> Array:
        """Return by how much the hand turned during a hold, in the scene, (3, 3)."""
        last = min(hold.stop, self.samples.n_steps) - 1
        link = self._hand(hold.holder)
        if link is None or last < hold.start:
            return np.eye(3)
        arm, base = arm_to(self.contacts.robot, link), rotation(self.samples.header.base_rpy)
        columns = [self.samples.header.joints.index(name) for name in arm.joints]
        begin, end = (
            matrix_of(tool_pose(arm, self.samples.position[step, columns].tolist())[1])
            for step in (hold.start, last)
        )
        turn: Array = base @ end @ begin.T @ base.T
        return turn

    def _opening(self, gripper: Gripper, hold: Hold) -> Flags:
        """Return the steps in which the servo drives the fingers apart, (n_steps,)."""
        header, ends = self.samples.header, gripper_ends(self.contacts.robot, gripper)
        columns = [header.joints.index(name) for name in gripper.joints]
        signs = np.array([gripper.sign(name) for name in gripper.joints])
        span = ends.opened - ends.closed
        asked = (self.samples.control[:, header.controls.index(gripper.name)] - ends.closed) / span
        at = ((self.samples.position[:, columns] * signs).mean(axis=1) - ends.closed) / span
        flags: Flags = (asked > asked[hold.start : hold.stop].min() + _RISE) & (asked > at + _LEADS)
        return flags

    def _was_detached(self, hold: Hold) -> bool:
        """Return whether the hold ended with a weld, which a call of the controller undoes."""
        return any(
            weld.body == hold.body and abs(weld.stop - hold.stop) <= POSE_EVERY
            for weld in self.contacts.log.welds
        )

    def _next_holds(self, hold: Hold) -> list[Hold]:
        names = self.contacts.log.bodies
        return [
            item
            for item in self.contacts.holds
            if names[item.body].name == names[hold.body].name and item.start >= hold.stop
        ]

    def _distances(self, holder: str, poses: Array, first: int, stop: int) -> Array:
        """Return how far an object is from the hand at its poses from one to another [m]."""
        link = self._hand(holder)
        if link is None or stop <= first:
            return np.zeros(0)
        rows = np.minimum(np.arange(first, stop) * POSE_EVERY, self.samples.n_steps - 1)
        arm = arm_to(self.contacts.robot, link)
        columns = [self.samples.header.joints.index(name) for name in arm.joints]
        in_base = tool_places(arm, self.samples.position[rows][:, columns])
        header = self.samples.header
        hand = in_base @ rotation(header.base_rpy).T + header.base_xyz
        distances: Array = np.linalg.norm(poses[first:stop, :3] - hand, axis=1)
        return distances

    def _hand(self, holder: str) -> str | None:
        """Return the link that bears a gripper's fingers, or the link that holds by a weld."""
        robot = self.contacts.robot
        for gripper in robot.grippers:
            if gripper.name == holder:
                bears = (
                    attachment
                    for attachment in robot.attachments
                    if attachment.name in gripper.joints
                )
                return next((bear.parent for bear in bears), None)
        return holder if holder in robot.link_names else None
