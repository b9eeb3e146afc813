"""What an arm's interface does in either ROS: limits, inverse kinematics, Cartesian paths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import interbotix_common_modules.angle_manipulation as ang
import numpy as np
from interbotix_xs_msgs.msg import JointGroupCommand, JointSingleCommand, JointTrajectoryCommand
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from tracerisk.common.geometry import screw_kinematics
from tracerisk.ros.messages.dialect import set_time

from . import mr_descriptions

REV = 2 * np.pi
"""One turn of a joint [rad]."""

_TOLERANCE = 0.001  # of the inverse kinematics [rad], [m]


def description(robot_model: str) -> Any:
    """Return the screw axes and the home pose of an arm.

    Raises:
        AttributeError: the model is not known.
    """
    return getattr(mr_descriptions, robot_model)


class ArmInterface:
    """Commands the joints of one group over the graph, and knows where its end effector is."""

    core: Any
    group_name: str
    group_info: Any
    robot_des: Any
    moving_time: Any = None
    accel_time: Any = None
    iterative_update_fk = True

    def _begin(self, robot_model: str) -> None:
        count = self.group_info.num_joints
        expected = self.robot_des.Slist.shape[1]
        if count != expected:
            raise RuntimeError(
                f"group '{self.group_name}' has {count} joints, and arm model '{robot_model}' has "
                f"{expected}: the robot that is simulated is another one; name the right one "
                "with --robot"
            )
        self.initial_guesses = [[0.0] * count for _ in range(3)]
        self.initial_guesses[1][0] = np.deg2rad(-120)
        self.initial_guesses[2][0] = np.deg2rad(120)
        self.info_index_map = {name: i for i, name in enumerate(self.group_info.joint_names)}
        self.capture_joint_positions()

    # Commands

    def set_trajectory_time(self, moving_time: Any = None, accel_time: Any = None) -> None:
        """Set how long moves take, and how long they speed up and slow down each [s]."""
        if moving_time is not None and moving_time != self.moving_time:
            self.moving_time = moving_time
            self._set_register("Profile_Velocity", moving_time)
        if accel_time is not None and accel_time != self.accel_time:
            self.accel_time = accel_time
            self._set_register("Profile_Acceleration", accel_time)

    def _set_register(self, name: str, seconds: float) -> None:
        self.core.robot_set_motor_registers("group", self.group_name, name, int(seconds * 1000))

    def _publish(
        self, positions: Sequence[float], moving_time: Any, accel_time: Any, blocking: bool
    ) -> None:
        self.set_trajectory_time(moving_time, accel_time)
        self.joint_commands = [float(position) for position in positions]
        self.core.pub_group.publish(
            JointGroupCommand(name=self.group_name, cmd=self.joint_commands)
        )
        if blocking:
            self.core._sleep(self.moving_time)
        if self.iterative_update_fk:
            self._update_Tsb()

    def set_joint_positions(
        self,
        joint_positions: Sequence[float],
        moving_time: Any = None,
        accel_time: Any = None,
        blocking: bool = True,
    ) -> bool:
        """Move to joint positions [rad]; False where they are beyond the limits."""
        if not self._is_within(joint_positions):
            return False
        self._publish(joint_positions, moving_time, accel_time, blocking)
        return True

    def go_to_home_pose(
        self, moving_time: Any = None, accel_time: Any = None, blocking: bool = True
    ) -> None:
        """Move all joints to 0."""
        self._publish([0.0] * self.group_info.num_joints, moving_time, accel_time, blocking)

    def go_to_sleep_pose(
        self, moving_time: Any = None, accel_time: Any = None, blocking: bool = True
    ) -> None:
        """Move to where the arm rests."""
        asleep = self.group_info.joint_sleep_positions
        self._publish(asleep, moving_time, accel_time, blocking)

    def set_single_joint_position(
        self,
        joint_name: str,
        position: float,
        moving_time: Any = None,
        accel_time: Any = None,
        blocking: bool = True,
    ) -> bool:
        """Move one joint; False where the position is beyond its limits.

        Raises:
            KeyError: the group has no such joint.
        """
        if not self._is_one_within(joint_name, position):
            return False
        self.set_trajectory_time(moving_time, accel_time)
        self.joint_commands[self.core.js_index_map[joint_name]] = float(position)
        self.core.pub_single.publish(JointSingleCommand(name=joint_name, cmd=float(position)))
        if blocking:
            self.core._sleep(self.moving_time)
        if self.iterative_update_fk:
            self._update_Tsb()
        return True

    def set_ee_pose_matrix(
        self,
        T_sd: Any,
        custom_guess: Any = None,
        execute: bool = True,
        moving_time: Any = None,
        accel_time: Any = None,
        blocking: bool = True,
    ) -> tuple[Any, bool]:
        """Bring the end effector to a pose (4, 4); return joint positions and whether they do.

        Where none of the guesses leads to positions within the limits nothing moves, and the
        positions of the last are returned.
        """
        guesses = self.initial_guesses if custom_guess is None else [custom_guess]
        result: Any = None
        for guess in guesses:
            result, is_there = screw_kinematics.inverse(
                self.robot_des.M, self.robot_des.Slist, np.asarray(T_sd), guess,
                _TOLERANCE, _TOLERANCE,
            )  # fmt: skip
            if not is_there:
                continue
            result = self._wrap_theta_list(result)
            if self._is_within(result):
                if execute:
                    self._publish(result, moving_time, accel_time, blocking)
                    self.T_sb = T_sd
                return result, True
        self.core._warn("No valid pose could be found. Will not execute")
        return result, False

    def set_ee_pose_components(
        self,
        x: float = 0,
        y: float = 0,
        z: float = 0,
        roll: float = 0,
        pitch: float = 0,
        yaw: Any = None,
        custom_guess: Any = None,
        execute: bool = True,
        moving_time: Any = None,
        accel_time: Any = None,
        blocking: bool = True,
    ) -> tuple[Any, bool]:
        """Bring the end effector to a place [m] and a direction [rad]; see `set_ee_pose_matrix`.

        An arm of fewer than six joints, or one given no yaw, faces away from its base.
        """
        if self.group_info.num_joints < 6 or yaw is None:
            yaw = math.atan2(y, x)
        goal = np.identity(4)
        goal[:3, :3] = ang.euler_angles_to_rotation_matrix([roll, pitch, yaw])
        goal[:3, 3] = [x, y, z]
        return self.set_ee_pose_matrix(
            goal, custom_guess, execute, moving_time, accel_time, blocking
        )

    def set_ee_cartesian_trajectory(
        self,
        x: float = 0,
        y: float = 0,
        z: float = 0,
        roll: float = 0,
        pitch: float = 0,
        yaw: float = 0,
        moving_time: Any = None,
        wp_moving_time: float = 0.2,
        wp_accel_time: float = 0.1,
        wp_period: float = 0.05,
    ) -> bool:
        """Move the end effector along a line, in the frame of the base turned as the arm faces.

        A waypoint follows every `wp_period` [s]. Where one of them cannot be reached nothing
        moves, and the result is False.
        """
        if self.group_info.num_joints < 6 and (y != 0 or yaw != 0):
            self.core._warn(
                "'y' and 'yaw' fields must be '0' when working with arms with fewer than 6dof."
            )
            return False
        turns = ang.rotation_matrix_to_euler_angles(self.T_sb[:3, :3])
        facing = np.identity(4)
        facing[:3, :3] = ang.euler_angles_to_rotation_matrix([0.0, 0.0, turns[2]])
        within = ang.trans_inv(facing) @ self.T_sb
        turns[2] = 0.0
        moving_time = self.moving_time if moving_time is None else moving_time
        accel_time = self.accel_time
        count = int(moving_time / wp_period)
        share = 1.0 / count
        path = [[float(joint_command) for joint_command in self.joint_commands]]
        for index in range(count):
            within[:3, 3] += share * np.array([x, y, z])
            turns = [at + share * by for at, by in zip(turns, (roll, pitch, yaw), strict=True)]
            within[:3, :3] = ang.euler_angles_to_rotation_matrix(turns)
            goal = facing @ within
            result, is_there = self.set_ee_pose_matrix(goal, path[-1], False, blocking=False)
            if not is_there:
                self.core._warn(
                    f"Only {index / count * 100:.2f}% of trajectory successfully planned. "
                    "Trajectory will not be executed."
                )
                return False
            path.append([float(item) for item in result])
        self.set_trajectory_time(wp_moving_time, wp_accel_time)
        self._send(path, wp_period)
        self.core._sleep(moving_time + wp_moving_time)
        self.T_sb = goal
        self.joint_commands = path[-1]
        self.set_trajectory_time(moving_time, accel_time)
        return True

    def _send(self, path: Sequence[Sequence[float]], period: float) -> None:
        message = JointTrajectory()
        message.header.stamp = self.core._now()
        message.joint_names = list(self.group_info.joint_names)
        points = []
        for index, positions in enumerate([self._measured("position"), *path[1:]]):
            point = JointTrajectoryPoint()
            point.positions = list(positions)
            set_time(point.time_from_start, round(index * period * 1e9))
            points.append(point)
        message.points = points
        self.core.pub_traj.publish(
            JointTrajectoryCommand(cmd_type="group", name=self.group_name, traj=message)
        )

    # What is known of the arm

    def get_joint_commands(self) -> list[float]:
        """Return the positions last commanded [rad]."""
        return list(self.joint_commands)

    def get_single_joint_command(self, joint_name: str) -> float:
        """Return the position last commanded of a joint [rad]."""
        return self.joint_commands[self.info_index_map[joint_name]]

    def get_ee_pose_command(self) -> Any:
        """Return the pose last commanded (4, 4)."""
        return np.array(self.T_sb)

    def get_ee_pose(self) -> Any:
        """Return the pose measured (4, 4)."""
        des = self.robot_des
        return screw_kinematics.forward(des.M, des.Slist, self._measured("position"))

    def capture_joint_positions(self) -> None:
        """Take the positions measured for those last commanded."""
        self.joint_commands = self._measured("position")
        self._update_Tsb()

    def _measured(self, field: str) -> list[float]:
        with self.core.js_mutex:
            values = getattr(self.core.joint_states, field)
            places = self.core.js_index_map
            return [float(values[places[name]]) for name in self.group_info.joint_names]

    def _update_Tsb(self) -> None:
        des = self.robot_des
        self.T_sb = screw_kinematics.forward(des.M, des.Slist, self.joint_commands)

    # Limits

    def _is_within(self, positions: Sequence[float]) -> bool:
        pairs = zip(range(self.group_info.num_joints), positions, strict=False)
        return all(self._allows(index, position) for index, position in pairs)

    def _is_one_within(self, joint_name: str, position: float) -> bool:
        return self._allows(self.info_index_map[joint_name], position)

    def _allows(self, index: int, position: float) -> bool:
        info = self.group_info
        rounded = int(position * 1000) / 1000.0
        speed = abs(rounded - self.joint_commands[index]) / float(self.moving_time)
        low, high = info.joint_lower_limits[index], info.joint_upper_limits[index]
        return bool(low <= rounded <= high and speed <= info.joint_velocity_limits[index])

    def _wrap_theta_list(self, theta_list: Any) -> Any:
        wrapped = (np.asarray(theta_list) + np.pi) % REV - np.pi
        for index, value in enumerate(wrapped):
            if round(value, 3) < round(self.group_info.joint_lower_limits[index], 3):
                wrapped[index] += REV
            elif round(value, 3) > round(self.group_info.joint_upper_limits[index], 3):
                wrapped[index] -= REV
        return wrapped
