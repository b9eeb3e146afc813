"""A way through points, sent to the motion controller."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from typing import Any

import actionlib
import rospy
from intera_interface import Limb
from intera_motion_msgs.msg import (
    MotionCommandAction,
    MotionCommandGoal,
    Trajectory,
    TrajectoryOptions,
    Waypoint,
)

from .waypoint import MotionWaypoint

__all__ = ["MotionTrajectory"]

_SERVER = "/motion/motion_command"


class MotionTrajectory:
    """Gathers points and sends them.

    Raises:
        OSError: the motion controller does not answer.
    """

    def __init__(
        self,
        label: str | None = None,
        joint_names: Sequence[str] | None = None,
        trajectory_options: Any = None,
        limb: Any = None,
    ) -> None:
        self._traj = Trajectory()
        self._limb = Limb() if limb is None else limb
        self._client = actionlib.SimpleActionClient(_SERVER, MotionCommandAction)
        if not self._client.wait_for_server(rospy.Duration(10.0)):
            raise OSError(f"no motion controller at {_SERVER}")
        self.set_label(label)
        self.set_joint_names(joint_names)
        self.set_trajectory_options(trajectory_options)

    def set_data(self, traj_msg: Any) -> None:
        """Take a Trajectory as it is."""
        self._traj = deepcopy(traj_msg)

    def set_label(self, label: str | None = None) -> None:
        """Set the name of the way."""
        self._traj.label = "default" if label is None else label

    def get_label(self) -> str:
        """Return the name of the way."""
        return str(self._traj.label)

    def set_joint_names(self, joint_names: Sequence[str] | None = None) -> None:
        """Set the joints of the points; without a value those of the limb."""
        self._traj.joint_names = list(joint_names or self._limb.joint_names())

    def set_trajectory_options(self, trajectory_options: Any = None) -> None:
        """Set whether joints or the tip go straight; without a value the joints."""
        if trajectory_options is None:
            trajectory_options = TrajectoryOptions(interpolation_type=TrajectoryOptions.JOINT)
        self._traj.trajectory_options = deepcopy(trajectory_options)

    def clear_waypoints(self) -> None:
        """Forget all points."""
        self._traj.waypoints = []

    def append_waypoint(self, waypoint: Any) -> bool:
        """Add a point; return whether it is one."""
        if isinstance(waypoint, MotionWaypoint):
            waypoint = waypoint.to_msg()
        if not isinstance(waypoint, Waypoint):
            rospy.logerr("Invalid waypoint - cannot append to trajectory!")
            return False
        self._traj.waypoints.append(deepcopy(waypoint))
        return True

    def to_msg(self) -> Any:
        """Return the way as a Trajectory."""
        return deepcopy(self._traj)

    def to_string(self) -> str:
        """Return the way as text."""
        return str(self._traj)

    def send_trajectory(self, wait_for_result: bool = True, timeout: float | None = None) -> Any:
        """Send the way; return the result, `None` without one in time.

        Where the tip goes straight, points of joint angles get their pose first.
        """
        if not self._traj.waypoints:
            rospy.logerr("Trajectory is empty! Cannot send.")
            return None
        if self._traj.trajectory_options.interpolation_type == TrajectoryOptions.CARTESIAN:
            self._traj.waypoints = [self._with_pose(point) for point in self._traj.waypoints]
        goal = MotionCommandGoal(command=MotionCommandGoal.MOTION_START, trajectory=self.to_msg())
        self._client.send_goal(goal)
        return self.wait_for_result(timeout) if wait_for_result else None

    def _with_pose(self, point: Any) -> Any:
        turn = point.pose.pose.orientation
        if any((turn.x, turn.y, turn.z, turn.w)) or not point.joint_positions:
            return point
        posed = MotionWaypoint(options=point.options, limb=self._limb)
        posed.set_joint_angles(point.joint_positions, point.active_endpoint, perform_fk=True)
        return posed.to_msg()

    def wait_for_result(self, timeout: float | None = None) -> Any:
        """Wait for the end of the way; return the result, `None` without one in time."""
        duration = rospy.Duration(0.0 if timeout is None else timeout)
        return self._client.get_result() if self._client.wait_for_result(duration) else None

    def stop_trajectory(self) -> None:
        """Stop the arm."""
        self._client.send_goal(MotionCommandGoal(command=MotionCommandGoal.MOTION_STOP))

    def get_state(self) -> Any:
        """Return the state of the goal, as actionlib has it."""
        return self._client.get_state()
