"""What the interface of the driver does in either ROS."""

from __future__ import annotations

import copy
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from interbotix_xs_msgs.msg import JointGroupCommand, JointSingleCommand, JointTrajectoryCommand
from interbotix_xs_msgs.srv import (
    MotorGains,
    OperatingModes,
    Reboot,
    RegisterValues,
    RobotInfo,
    TorqueEnable,
)
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

SERVICES = {
    "srv_set_op_modes": ("set_operating_modes", OperatingModes),
    "srv_set_pids": ("set_motor_pid_gains", MotorGains),
    "srv_set_reg": ("set_motor_registers", RegisterValues),
    "srv_get_reg": ("get_motor_registers", RegisterValues),
    "srv_get_info": ("get_robot_info", RobotInfo),
    "srv_torque": ("torque_enable", TorqueEnable),
    "srv_reboot": ("reboot_motors", Reboot),
}
"""What is called by each attribute: the name and the type of a service."""


class RobotCore(ABC):
    """Calls the driver's services, publishes its commands and keeps its joint states."""

    srv_set_op_modes: Any
    srv_set_pids: Any
    srv_set_reg: Any
    srv_get_reg: Any
    srv_get_info: Any
    srv_torque: Any
    srv_reboot: Any
    pub_group: Any
    pub_single: Any
    pub_traj: Any

    def __init__(self, robot_model: str, robot_name: str | None) -> None:
        self.robot_name = robot_model if robot_name is None else robot_name
        self.joint_states: Any = None
        self.js_mutex = threading.Lock()

    def _index_joints(self) -> None:
        names: Iterable[str] = self.robot_get_joint_states().name
        self.js_index_map: dict[str, int] = {name: i for i, name in enumerate(names)}

    @abstractmethod
    def _ask(self, service: Any, **request: Any) -> Any:
        """Call a service with the fields of its request, and return the response."""

    @abstractmethod
    def _duration(self, seconds: float) -> Any: ...

    @abstractmethod
    def _now(self) -> Any: ...

    @abstractmethod
    def _sleep(self, duration: float) -> None: ...

    @abstractmethod
    def _warn(self, message: str) -> None: ...

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
        self._ask(
            self.srv_set_op_modes,
            cmd_type=cmd_type,
            name=name,
            mode=mode,
            profile_type=profile_type,
            profile_velocity=profile_velocity,
            profile_acceleration=profile_acceleration,
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
        gains = {"kp_pos": kp_pos, "ki_pos": ki_pos, "kd_pos": kd_pos, "k1": k1, "k2": k2}
        speed_gains = {"kp_vel": kp_vel, "ki_vel": ki_vel}
        self._ask(self.srv_set_pids, cmd_type=cmd_type, name=name, **gains, **speed_gains)

    def robot_set_motor_registers(self, cmd_type: str, name: str, reg: str, value: int) -> None:
        """Set a register of servos."""
        self._ask(self.srv_set_reg, cmd_type=cmd_type, name=name, reg=reg, value=value)

    def robot_get_motor_registers(self, cmd_type: str, name: str, reg: str) -> Any:
        """Return the response with a register's `values`."""
        return self._ask(self.srv_get_reg, cmd_type=cmd_type, name=name, reg=reg)

    def robot_get_robot_info(self, cmd_type: str, name: str) -> Any:
        """Return the response with joints and their limits."""
        return self._ask(self.srv_get_info, cmd_type=cmd_type, name=name)

    def robot_torque_enable(self, cmd_type: str, name: str, enable: bool) -> None:
        """Torque servos on or off."""
        self._ask(self.srv_torque, cmd_type=cmd_type, name=name, enable=enable)

    def robot_reboot_motors(
        self, cmd_type: str, name: str, enable: bool, smart_reboot: bool = False
    ) -> None:
        """Reboot servos, with `smart_reboot` only those in an error state."""
        asked = {"cmd_type": cmd_type, "name": name, "enable": enable, "smart_reboot": smart_reboot}
        self._ask(self.srv_reboot, **asked)

    def robot_write_commands(self, group_name: str, commands: Sequence[float]) -> None:
        """Command a group of servos."""
        self.pub_group.publish(JointGroupCommand(name=group_name, cmd=commands))

    def robot_write_joint_command(self, joint_name: str, command: float) -> None:
        """Command one servo."""
        self.pub_single.publish(JointSingleCommand(name=joint_name, cmd=command))

    def _write_trajectory(
        self, cmd_type: str, name: str, kind: str, steps: Iterable[Mapping[float, Sequence[float]]]
    ) -> None:
        message = JointTrajectory()
        for step in steps:
            for time, values in step.items():
                point = JointTrajectoryPoint()
                if kind == "position":
                    point.positions = values
                elif kind == "velocity":
                    point.velocities = values
                point.time_from_start = self._duration(time)
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
