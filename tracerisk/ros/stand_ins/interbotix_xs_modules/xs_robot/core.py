"""The driver of a robot over the graph (ROS 2)."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from threading import Lock
from typing import Any

import rclpy
from interbotix_common_modules.common_robot.robot import (
    InterbotixRobotNode,
    create_interbotix_global_node,
)
from interbotix_xs_msgs.msg import JointGroupCommand, JointSingleCommand, JointTrajectoryCommand
from interbotix_xs_msgs.srv import (
    MotorGains,
    OperatingModes,
    Reboot,
    RegisterValues,
    RobotInfo,
    TorqueEnable,
)
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.logging import LoggingSeverity, set_logger_level
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

__all__ = ["InterbotixRobotXSCore"]


class InterbotixRobotXSCore:
    """Calls the driver's services, publishes its commands and keeps its joint states."""

    def __init__(
        self,
        robot_model: str,
        robot_name: str | None = None,
        topic_joint_states: str = "joint_states",
        logging_level: Any = LoggingSeverity.INFO,
        node_name: str = "interbotix_robot_manipulation",
        node: InterbotixRobotNode | None = None,
        args: Any = None,
    ) -> None:
        self.robot_model = robot_model
        self.robot_name = robot_model if robot_name is None else robot_name
        self.node_name = node_name
        self.ns = f"/{self.robot_name}" if self.robot_name else ""
        self.robot_node = create_interbotix_global_node() if node is None else node
        set_logger_level(node_name, logging_level)
        self.topic_joint_states = topic_joint_states
        self.joint_states: Any = None
        self.js_mutex = Lock()
        group = ReentrantCallbackGroup()

        def client(kind: Any, name: str) -> Any:
            return self.robot_node.create_client(kind, f"{self.ns}/{name}", callback_group=group)

        def publisher(kind: Any, name: str) -> Any:
            topic = f"{self.ns}/commands/{name}"
            return self.robot_node.create_publisher(kind, topic, 10, callback_group=group)

        self.srv_set_op_modes = client(OperatingModes, "set_operating_modes")
        self.srv_set_pids = client(MotorGains, "set_motor_pid_gains")
        self.srv_set_reg = client(RegisterValues, "set_motor_registers")
        self.srv_get_reg = client(RegisterValues, "get_motor_registers")
        self.srv_get_info = client(RobotInfo, "get_robot_info")
        self.srv_torque = client(TorqueEnable, "torque_enable")
        self.srv_reboot = client(Reboot, "reboot_motors")
        while not self.srv_set_op_modes.wait_for_service(timeout_sec=5.0) and rclpy.ok():
            self.robot_node.logerror(
                f"Failed to find services under namespace '{self.ns}'. Is the xs_sdk running "
                "under that namespace?"
            )
        for service in (
            self.srv_set_pids,
            self.srv_set_reg,
            self.srv_get_reg,
            self.srv_get_info,
            self.srv_torque,
            self.srv_reboot,
        ):
            service.wait_for_service()
        self.pub_group = publisher(JointGroupCommand, "joint_group")
        self.pub_single = publisher(JointSingleCommand, "joint_single")
        self.pub_traj = publisher(JointTrajectoryCommand, "joint_trajectory")
        self.sub_joint_states = self.robot_node.create_subscription(
            JointState,
            f"{self.ns}/{topic_joint_states}",
            self._joint_state_cb,
            10,
            callback_group=group,
        )
        while self.joint_states is None and rclpy.ok():
            rclpy.spin_once(self.robot_node)
        names: Any = self.robot_get_joint_states().name
        self.js_index_map: dict[str, int] = {name: i for i, name in enumerate(names)}
        self.robot_node.loginfo(
            f"\n\tRobot Name: {self.robot_name}\n\tRobot Model: {self.robot_model}"
        )
        self.robot_node.loginfo("Initialized InterbotixRobotXSCore!")

    def get_node(self) -> InterbotixRobotNode:
        """Return the node that the interface is on."""
        return self.robot_node

    def _call(self, client: Any, request: Any) -> Any:
        future = client.call_async(request)
        self.robot_node.wait_until_future_complete(future)
        return future.result()

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
        request = OperatingModes.Request(
            cmd_type=cmd_type,
            name=name,
            mode=mode,
            profile_type=profile_type,
            profile_velocity=profile_velocity,
            profile_acceleration=profile_acceleration,
        )
        self._call(self.srv_set_op_modes, request)

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
        request = MotorGains.Request(
            cmd_type=cmd_type,
            name=name,
            kp_pos=kp_pos,
            ki_pos=ki_pos,
            kd_pos=kd_pos,
            k1=k1,
            k2=k2,
            kp_vel=kp_vel,
            ki_vel=ki_vel,
        )
        self._call(self.srv_set_pids, request)

    def robot_set_motor_registers(self, cmd_type: str, name: str, reg: str, value: int) -> None:
        """Set a register of servos."""
        request = RegisterValues.Request(cmd_type=cmd_type, name=name, reg=reg, value=value)
        self._call(self.srv_set_reg, request)

    def robot_get_motor_registers(self, cmd_type: str, name: str, reg: str) -> Any:
        """Return the values of a register."""
        request = RegisterValues.Request(cmd_type=cmd_type, name=name, reg=reg)
        return self._call(self.srv_get_reg, request).values

    def robot_get_robot_info(self, cmd_type: str, name: str) -> Any:
        """Return the response with joints and their limits."""
        return self._call(self.srv_get_info, RobotInfo.Request(cmd_type=cmd_type, name=name))

    def robot_torque_enable(self, cmd_type: str, name: str, enable: bool) -> None:
        """Torque servos on or off."""
        request = TorqueEnable.Request(cmd_type=cmd_type, name=name, enable=enable)
        self._call(self.srv_torque, request)

    def robot_reboot_motors(
        self, cmd_type: str, name: str, enable: bool, smart_reboot: bool = False
    ) -> None:
        """Reboot servos, with `smart_reboot` only those in an error state."""
        request = Reboot.Request(
            cmd_type=cmd_type, name=name, enable=enable, smart_reboot=smart_reboot
        )
        self._call(self.srv_reboot, request)

    def robot_write_commands(self, group_name: str, commands: Sequence[float]) -> None:
        """Command a group of servos."""
        self.pub_group.publish(JointGroupCommand(name=group_name, cmd=commands))

    def robot_write_joint_command(self, joint_name: str, command: float) -> None:
        """Command one servo."""
        self.pub_single.publish(JointSingleCommand(name=joint_name, cmd=command))

    def robot_write_trajectory(
        self,
        cmd_type: str,
        name: str,
        traj_type: str,
        raw_traj: Sequence[Mapping[float, Sequence[float]]],
    ) -> None:
        """Command waypoints: one mapping each from the time [s] to positions or velocities."""
        message = JointTrajectory()
        for step in raw_traj:
            for time, values in step.items():
                point = JointTrajectoryPoint()
                if traj_type == "position":
                    point.positions = values
                elif traj_type == "velocity":
                    point.velocities = values
                point.time_from_start = Duration(seconds=time).to_msg()
                message.points.append(point)
        self.pub_traj.publish(JointTrajectoryCommand(cmd_type=cmd_type, name=name, traj=message))

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

    def _joint_state_cb(self, msg: Any) -> None:
        with self.js_mutex:
            self.joint_states = msg
