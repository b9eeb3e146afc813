"""The driver of a robot over the graph (ROS 1)."""

from __future__ import annotations

import copy
import sys
import threading
from collections.abc import Mapping, Sequence
from typing import Any

import rospy
from interbotix_xs_msgs.msg import JointGroupCommand, JointSingleCommand, JointTrajectoryCommand
from interbotix_xs_msgs.srv import (
    MotorGains,
    OperatingModes,
    Reboot,
    RegisterValues,
    RobotInfo,
    TorqueEnable,
)
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

__all__ = ["InterbotixRobotXSCore"]

_SERVICES = (
    "set_operating_modes",
    "set_motor_pid_gains",
    "set_motor_registers",
    "get_motor_registers",
    "get_robot_info",
    "torque_enable",
    "reboot_motors",
)


class InterbotixRobotXSCore:
    """Calls the driver's services, publishes its commands and keeps its joint states."""

    def __init__(
        self,
        robot_model: str,
        robot_name: str | None = None,
        init_node: bool = True,
        joint_state_topic: str = "joint_states",
    ) -> None:
        self.joint_states: Any = None
        self.js_mutex = threading.Lock()
        self.robot_name = robot_model if robot_name is None else robot_name
        if init_node:
            rospy.init_node(self.robot_name + "_robot_manipulation")
        space = f"/{self.robot_name}/"
        try:
            for name in _SERVICES:
                rospy.wait_for_service(space + name, timeout=5.0)
        except rospy.exceptions.ROSException as error:
            rospy.logerr(
                f"{error} The robot '{self.robot_name}' is not discoverable. Did you enter the "
                "correct robot_name parameter? Is the xs_sdk node running? Quitting..."
            )
            sys.exit(1)
        self.srv_set_op_modes = rospy.ServiceProxy(space + "set_operating_modes", OperatingModes)
        self.srv_set_pids = rospy.ServiceProxy(space + "set_motor_pid_gains", MotorGains)
        self.srv_set_reg = rospy.ServiceProxy(space + "set_motor_registers", RegisterValues)
        self.srv_get_reg = rospy.ServiceProxy(space + "get_motor_registers", RegisterValues)
        self.srv_get_info = rospy.ServiceProxy(space + "get_robot_info", RobotInfo)
        self.srv_torque = rospy.ServiceProxy(space + "torque_enable", TorqueEnable)
        self.srv_reboot = rospy.ServiceProxy(space + "reboot_motors", Reboot)
        commands = space + "commands/"
        self.pub_group = rospy.Publisher(commands + "joint_group", JointGroupCommand, queue_size=1)
        self.pub_single = rospy.Publisher(
            commands + "joint_single", JointSingleCommand, queue_size=1
        )
        self.pub_traj = rospy.Publisher(
            commands + "joint_trajectory", JointTrajectoryCommand, queue_size=1
        )
        self.sub_joint_states = rospy.Subscriber(
            space + joint_state_topic, JointState, self.joint_state_cb
        )
        while self.joint_states is None and not rospy.is_shutdown():
            rospy.sleep(0.01)
        names: Any = self.robot_get_joint_states().name
        self.js_index_map: dict[str, int] = {name: i for i, name in enumerate(names)}
        rospy.sleep(0.5)
        print(f"Robot Name: {self.robot_name}\nRobot Model: {robot_model}")  # noqa: T201
        print("Initialized InterbotixRobotXSCore!\n")  # noqa: T201

    def robot_set_operating_modes(
        self,
        cmd_type: str,
        name: str,
        mode: str,
        profile_type: str = "velocity",
        profile_velocity: int = 0,
        profile_acceleration: int = 0,
    ) -> None:
        """Set how servos take their commands."""
        self.srv_set_op_modes(
            cmd_type, name, mode, profile_type, profile_velocity, profile_acceleration
        )

    def robot_set_motor_pid_gains(
        self,
        cmd_type: str,
        name: str,
        kp_pos: int,
        ki_pos: int = 0,
        kd_pos: int = 0,
        k1: int = 0,
        k2: int = 0,
        kp_vel: int = 100,
        ki_vel: int = 1920,
    ) -> None:
        """Set the gains of servos; the twin keeps them and moves as before."""
        self.srv_set_pids(cmd_type, name, kp_pos, ki_pos, kd_pos, k1, k2, kp_vel, ki_vel)

    def robot_set_motor_registers(self, cmd_type: str, name: str, reg: str, value: int) -> None:
        """Set a register of servos."""
        self.srv_set_reg(cmd_type, name, reg, value)

    def robot_get_motor_registers(self, cmd_type: str, name: str, reg: str) -> Any:
        """Return the response with a register's `values`."""
        return self.srv_get_reg(cmd_type=cmd_type, name=name, reg=reg)

    def robot_get_robot_info(self, cmd_type: str, name: str) -> Any:
        """Return the response with joints and their limits."""
        return self.srv_get_info(cmd_type, name)

    def robot_torque_enable(self, cmd_type: str, name: str, enable: bool) -> None:
        """Torque servos on or off."""
        self.srv_torque(cmd_type, name, enable)

    def robot_reboot_motors(
        self, cmd_type: str, name: str, enable: bool, smart_reboot: bool = False
    ) -> None:
        """Reboot servos, with `smart_reboot` only those in an error state."""
        self.srv_reboot(cmd_type, name, enable, smart_reboot)

    def robot_write_commands(self, group_name: str, commands: Sequence[float]) -> None:
        """Command a group of servos."""
        self.pub_group.publish(JointGroupCommand(group_name, commands))

    def robot_write_joint_command(self, joint_name: str, command: float) -> None:
        """Command one servo."""
        self.pub_single.publish(JointSingleCommand(joint_name, command))

    def robot_write_trajectory(
        self,
        cmd_type: str,
        name: str,
        type: str,
        raw_traj: Sequence[Mapping[float, Sequence[float]]],
    ) -> None:
        """Command waypoints: one mapping each from the time [s] to positions or velocities."""
        message = JointTrajectory()
        for step in raw_traj:
            for time, values in step.items():
                point = JointTrajectoryPoint()
                if type == "position":
                    point.positions = values
                elif type == "velocity":
                    point.velocities = values
                point.time_from_start = rospy.Duration.from_sec(time)
                message.points.append(point)
        self.pub_traj.publish(JointTrajectoryCommand(cmd_type, name, message))

    def robot_get_joint_states(self) -> Any:
        """Return a copy of the last joint states."""
        with self.js_mutex:
            return copy.deepcopy(self.joint_states)

    def robot_get_single_joint_state(self, name: str) -> dict[str, float]:
        """Return `position`, `velocity` and `effort` of a joint.

        Raises:
            ValueError: there is no such joint.
        """
        states = self.robot_get_joint_states()
        index = states.name.index(name)
        return {
            "position": states.position[index],
            "velocity": states.velocity[index],
            "effort": states.effort[index],
        }

    def joint_state_cb(self, msg: Any) -> None:
        """Keep the last joint states."""
        with self.js_mutex:
            self.joint_states = msg
