"""What the arms of a Baxter and of a Sawyer report, which both libraries hand out alike."""

from __future__ import annotations

import collections
from collections.abc import Mapping
from copy import deepcopy
from typing import Any


class LimbReadings:
    """Keeps the last states of an arm's joints and of its end point."""

    Point = collections.namedtuple("Point", ["x", "y", "z"])
    Quaternion = collections.namedtuple("Quaternion", ["x", "y", "z", "w"])

    def __init__(self, limb: str) -> None:
        self.name = limb
        self._joint_angle: dict[str, float] = {}
        self._joint_velocity: dict[str, float] = {}
        self._joint_effort: dict[str, float] = {}
        self._cartesian_pose: dict[str, Any] = {}
        self._cartesian_velocity: dict[str, Any] = {}

    def _on_joint_states(self, msg: Any) -> None:
        joints = self.joint_names()
        for index, name in enumerate(msg.name):
            if name in joints:
                self._joint_angle[name] = msg.position[index]
                self._joint_velocity[name] = msg.velocity[index]
                self._joint_effort[name] = msg.effort[index]

    def _on_endpoint_states(self, msg: Any) -> None:
        self._cartesian_pose = self._pose_of(msg)
        self._cartesian_velocity = self._velocity_of(msg)

    def _pose_of(self, msg: Any) -> dict[str, Any]:
        place, turn = msg.pose.position, msg.pose.orientation
        return {
            "position": self.Point(place.x, place.y, place.z),
            "orientation": self.Quaternion(turn.x, turn.y, turn.z, turn.w),
        }

    def _velocity_of(self, msg: Any) -> dict[str, Any]:
        linear, angular = msg.twist.linear, msg.twist.angular
        return {
            "linear": self.Point(linear.x, linear.y, linear.z),
            "angular": self.Point(angular.x, angular.y, angular.z),
        }

    def _is_at(self, positions: Mapping[str, float], threshold: float) -> bool:
        """Return whether all joints are within a threshold of their positions [rad]."""
        return all(
            abs(goal - self._joint_angle[joint]) < threshold
            for joint, goal in positions.items()
            if joint in self._joint_angle
        )

    def joint_names(self) -> list[str]:
        """Return the joints, from the base to the wrist."""
        raise NotImplementedError

    def joint_angle(self, joint: str) -> float:
        """Return the angle of a joint [rad]."""
        return self._joint_angle[joint]

    def joint_angles(self) -> dict[str, float]:
        """Return the angles of all joints [rad]."""
        return deepcopy(self._joint_angle)

    def joint_velocity(self, joint: str) -> float:
        """Return the velocity of a joint [rad/s]."""
        return self._joint_velocity[joint]

    def joint_velocities(self) -> dict[str, float]:
        """Return the velocities of all joints [rad/s]."""
        return deepcopy(self._joint_velocity)

    def joint_effort(self, joint: str) -> float:
        """Return the effort of a joint [N m]."""
        return self._joint_effort[joint]

    def joint_efforts(self) -> dict[str, float]:
        """Return the efforts of all joints [N m]."""
        return deepcopy(self._joint_effort)

    def endpoint_pose(self) -> dict[str, Any]:
        """Return where the end point is: `position` [m] and `orientation`."""
        return deepcopy(self._cartesian_pose)

    def endpoint_velocity(self) -> dict[str, Any]:
        """Return the end point's velocity: `linear` [m/s] and `angular`."""
        return deepcopy(self._cartesian_velocity)

    def endpoint_effort(self) -> dict[str, Any]:
        """Return the wrench at the end point.

        Raises:
            NotImplementedError: always; the twin estimates none.
        """
        raise NotImplementedError("Limb.endpoint_effort: the twin estimates no endpoint wrench")
