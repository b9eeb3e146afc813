"""What a client of a planning group can ask about the robot."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from moveit_msgs.msg import RobotState

from tracerisk.errors import one_of
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.readings.read_poses import ReadPoses
from tracerisk.ros.transforms.poses import conjugate, multiply, rotate, rpy_from_quaternion
from tracerisk.twin.physics import motion

from . import conversions
from ._binding import check_arguments, received
from ._group_settings import GroupSettings
from .exception import MoveItCommanderException


class GroupState(GroupSettings):
    """Names and present values of the group's joints and of its end effector."""

    def __init__(self, name: str, robot_description: str = "robot_description") -> None:
        super().__init__(name, robot_description)
        self._start_state: dict[str, float] | None = None

    # Names

    def get_joints(self) -> list[str]:
        """Return the names of the group's joints, with those that are fixed or follow another."""
        return list(self._server.group_joints(self._name))

    def get_active_joints(self) -> list[str]:
        """Return the names of the group's joints that are not fixed and follow no other one."""
        return list(self._server.active_joints(self._name))

    def get_variable_count(self) -> int:
        """Return how many values a joint target has, one of each that follows another, too."""
        return len(self._server.variables(self._name))

    def has_end_effector_link(self) -> bool:
        """Return whether poses can be asked for without naming a link."""
        return bool(self._end_effector_link)

    def get_end_effector_link(self) -> str:
        """Return the link that poses are for, or the empty string."""
        return self._end_effector_link

    def set_end_effector_link(self, link_name: str) -> None:
        """Set the link that poses are for.

        Raises:
            ArgumentError: it is no string.
            MoveItCommanderException: the robot has no such link.
        """
        check_arguments("set_end_effector_link", (link_name, "std::string"))
        links = self._server.robot.link_names
        if link_name not in links:
            raise MoveItCommanderException(
                f"Unable to set end effector link '{link_name}'; {one_of(links, link_name)}"
            )
        self._end_effector_link = link_name

    # Values

    def get_current_joint_values(self) -> list[float]:
        """Return the positions of the group's joints, with those that follow [rad or m]."""
        positions = self._server.positions()
        return [positions[name] for name in self._server.variables(self._name)]

    def get_current_pose(self, end_effector_link: str = "") -> Any:
        """Return the pose of the end effector in the planning frame, as a PoseStamped."""
        pose = self._link_pose(end_effector_link, "get the pose of")
        link = end_effector_link or self._end_effector_link
        frame = self.get_planning_frame()
        current().client(ReadPoses).read(frame, pose, link, "get_current_pose")
        return conversions.list_to_pose_stamped([*pose.position, *pose.orientation], frame)

    def get_current_rpy(self, end_effector_link: str = "") -> list[float]:
        """Return roll, pitch and yaw of the end effector in the planning frame [rad]."""
        pose = self._link_pose(end_effector_link, "get the rpy of")
        return list(rpy_from_quaternion(pose.orientation))

    def get_current_state(self) -> Any:
        """Return the state of the whole robot as a RobotState."""
        return conversions._state_message(self._server.positions(), self.get_planning_frame())

    def get_current_state_bounded(self) -> Any:
        """Return the state of the whole robot, every joint within its limits."""
        return self.enforce_bounds(self.get_current_state())

    def enforce_bounds(self, robot_state_msg: Any) -> Any:
        """Return a RobotState with every joint within its limits."""
        given = received(RobotState, robot_state_msg).joint_state
        positions = {}
        for name, value in zip(given.name, given.position, strict=True):
            joint = self._server.robot.joint(name)
            positions[name] = min(max(value, joint.lower), joint.upper)
        return conversions._state_message(positions, self.get_planning_frame())

    def get_random_joint_values(self) -> list[float]:
        """Return joint positions drawn evenly within the limits; the run's seed decides."""
        return list(self._server.random_target(self._name).values())

    def get_random_pose(self, end_effector_link: str = "") -> Any:
        """Return a pose that the end effector can reach, as a PoseStamped."""
        link = self._link(end_effector_link, "get the pose of")
        pose = self._server.forward(self._server.random_target(self._name), link)
        values = [*pose.position, *pose.orientation]
        return conversions.list_to_pose_stamped(values, self.get_planning_frame())

    def get_jacobian_matrix(
        self, joint_values: Sequence[float], reference_point: Sequence[float] | None = None
    ) -> Any:
        """Return the Jacobian (6, n_joints) of a point in the frame of the group's last link.

        Rows are velocities [m/s] and turning rates [rad/s] in the planning frame.
        """
        link = self._link("", "get the jacobian of")
        point = (0.0, 0.0, 0.0) if reference_point is None else reference_point
        if len(point) != 3:
            raise ValueError(f"reference point needs to have 3 elements, got {len(point)}")
        names = list(self._server.variables(self._name))
        step = 1e-5
        columns = []
        for index in range(len(names)):
            ends = []
            for sign in (1.0, -1.0):
                values = dict(zip(names, joint_values, strict=True))
                values[names[index]] += sign * step
                ends.append(self._server.forward(values, link))
            columns.append(_rate(ends[0], ends[1], point, 2 * step))
        return np.array(columns).T

    # Where plans start

    def set_start_state_to_current_state(self) -> None:
        """Start plans where the robot is when they are made."""
        self._start_state = None

    def set_start_state(self, msg: Any) -> None:
        """Start plans at a RobotState; joints that it leaves out stand where they are.

        Raises:
            MoveItCommanderException: the robot has no joint of a name in it.
        """
        self._start_state = self._state_positions(received(RobotState, msg)) or None

    def _state_positions(self, state: Any) -> dict[str, float]:
        given = state.joint_state
        known = [joint.name for joint in self._server.robot.joints]
        for name in given.name:
            if name not in known:
                raise MoveItCommanderException(
                    f"the robot state has a joint '{name}' that the robot lacks; "
                    f"{one_of(known, name)}"
                )
        return dict(zip(given.name, map(float, given.position), strict=True))

    def _start(self) -> Mapping[str, float] | None:
        if self._start_state is None:
            return None
        return {**self._server.positions(), **self._start_state}

    def _link(self, end_effector_link: str, what: str) -> str:
        """Return the link that is meant; it raises TypeError for what has no length, as `None`."""
        link = end_effector_link if len(end_effector_link) else self._end_effector_link
        if not link:
            raise MoveItCommanderException(f"There is no end effector to {what}")
        check_arguments("set_end_effector_link", (link, "std::string"))
        return link

    def _link_pose(self, end_effector_link: str, what: str) -> motion.Pose:
        link = self._link(end_effector_link, what)
        links = self._server.robot.link_names
        if link not in links:
            raise MoveItCommanderException(f"There is no link '{link}'; {one_of(links, link)}")
        return self._server.link_pose(link)


def _rate(
    after: motion.Pose, before: motion.Pose, point: Sequence[float], span: float
) -> list[float]:
    """Return linear and angular rate of a point of a body between two poses, per unit of span."""
    ends = [
        np.array(pose.position) + np.array(rotate(pose.orientation, point))
        for pose in (after, before)
    ]
    x, y, z, w = multiply(after.orientation, conjugate(before.orientation))
    turn = 2.0 * np.array([x, y, z]) * np.sign(w or 1.0)
    return [*((ends[0] - ends[1]) / span), *(turn / span)]
