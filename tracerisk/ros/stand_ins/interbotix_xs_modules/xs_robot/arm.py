"""An arm and its gripper (ROS 2)."""

from __future__ import annotations

from typing import Any

from interbotix_common_modules.common_robot.robot import (
    InterbotixRobotNode,
    interbotix_is_up,
    robot_shutdown,
    robot_startup,
)
from rclpy.executors import MultiThreadedExecutor
from rclpy.logging import LoggingSeverity

from .._arm import REV, ArmInterface, description
from .core import InterbotixRobotXSCore
from .gripper import InterbotixGripperXSInterface

__all__ = ["REV", "InterbotixArmXSInterface", "InterbotixManipulatorXS"]


class InterbotixManipulatorXS:
    """An arm by its model: `core` the driver, `arm`, and `gripper` where it has a name.

    `start_on_init`, `start`, `run` and `shutdown` are of the first release for ROS 2, which spins
    by itself; later ones leave that to `robot_startup`. Where `start_on_init` is not given, the
    release is not known, and nothing spins before one of them is called.
    """

    def __init__(
        self,
        robot_model: str,
        group_name: str = "arm",
        gripper_name: str | None = "gripper",
        robot_name: str | None = None,
        moving_time: float = 2.0,
        accel_time: float = 0.3,
        gripper_pressure: float = 0.5,
        gripper_pressure_lower_limit: int = 150,
        gripper_pressure_upper_limit: int = 350,
        topic_joint_states: str = "joint_states",
        logging_level: Any = LoggingSeverity.INFO,
        node_name: str = "robot_manipulation",
        node: InterbotixRobotNode | None = None,
        iterative_update_fk: bool = True,
        args: Any = None,
        *,
        start_on_init: bool = False,
    ) -> None:
        self.core = InterbotixRobotXSCore(
            robot_model, robot_name, topic_joint_states, logging_level, node_name, node, args
        )
        self.arm = InterbotixArmXSInterface(
            self.core, robot_model, group_name, moving_time, accel_time, iterative_update_fk
        )
        if gripper_name is not None:
            self.gripper = InterbotixGripperXSInterface(
                self.core,
                gripper_name,
                gripper_pressure,
                gripper_pressure_lower_limit,
                gripper_pressure_upper_limit,
            )
        self.robot_name = robot_name
        if start_on_init:
            self.start()

    def get_node(self) -> InterbotixRobotNode:
        """Return the node of the driver's interface."""
        return self.core.robot_node

    def start(self) -> None:
        """Spin the driver's node on a thread of its own."""
        if not interbotix_is_up():
            robot_startup(self.core.get_node())

    def run(self) -> None:
        """Spin the driver's node on this thread until ROS shuts down."""
        executor = MultiThreadedExecutor()
        executor.add_node(self.core.get_node())
        executor.spin()

    def shutdown(self) -> None:
        """Destroy the driver's node, shut ROS down and end the thread that spins."""
        robot_shutdown(self.core.get_node())


class InterbotixArmXSInterface(ArmInterface):
    """Moves an arm by joint positions, poses and lines."""

    def __init__(
        self,
        core: InterbotixRobotXSCore,
        robot_model: str,
        group_name: str,
        moving_time: float = 2.0,
        accel_time: float = 0.3,
        iterative_update_fk: bool = True,
    ) -> None:
        self.core = core
        self.robot_model = robot_model
        # As in the library: times given here count as the driver's, which does not get them.
        self.moving_time, self.accel_time = moving_time, accel_time
        self.group_name = group_name
        self.iterative_update_fk = iterative_update_fk
        self.robot_des = description(robot_model)
        node = core.get_node()
        self.group_info = core.robot_get_robot_info("group", group_name)
        if self.group_info.profile_type != "time":
            node.logwarn(f"Group '{group_name}' profile_type not set to 'time'.")
        if self.group_info.mode != "position":
            node.logwarn(f"Group '{group_name}' operating mode not set to 'position'.")
        self._begin(robot_model)
        node.loginfo(
            f"\n\tArm Group Name: {group_name}\n\tMoving Time: {moving_time:.2f} seconds\n"
            f"\tAcceleration Time: {accel_time:.2f} seconds\n\tDrive Mode: Time-Based-Profile"
        )
        node.loginfo("Initialized InterbotixArmXSInterface!")

    def get_joint_positions(self) -> list[float]:
        """Return the joints' positions [rad]."""
        return self._measured("position")

    def get_joint_velocities(self) -> list[float]:
        """Return the joints' velocities [rad/s]."""
        return self._measured("velocity")

    def get_joint_efforts(self) -> list[float]:
        """Return the joints' efforts."""
        return self._measured("effort")

    def get_number_of_joints(self) -> int:
        """Return how many joints the group has."""
        return int(self.group_info.num_joints)

    # The names by which subclasses of the library's know these.

    _publish_commands = ArmInterface._publish
    _check_joint_limits = ArmInterface._is_within
    _check_single_joint_limit = ArmInterface._is_one_within
