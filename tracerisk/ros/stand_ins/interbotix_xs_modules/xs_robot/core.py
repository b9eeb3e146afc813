"""The driver of a robot over the graph (ROS 2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import rclpy
from interbotix_common_modules.common_robot.robot import (
    InterbotixRobotNode,
    create_interbotix_global_node,
)
from interbotix_xs_msgs.msg import JointGroupCommand, JointSingleCommand, JointTrajectoryCommand
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.logging import LoggingSeverity, set_logger_level
from sensor_msgs.msg import JointState

from .._core import SERVICES, RobotCore

__all__ = ["InterbotixRobotXSCore"]


class InterbotixRobotXSCore(RobotCore):
    """Calls the driver's services, publishes its commands and keeps its joint states.

    In the first release for ROS 2 it is a node itself: what it lacks, its node has.
    """

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
        super().__init__(robot_model, robot_name)
        self.robot_model = robot_model
        self.node_name = node_name
        self.ns = f"/{self.robot_name}" if self.robot_name else ""
        self.robot_node = create_interbotix_global_node() if node is None else node
        set_logger_level(node_name, logging_level)
        self.topic_joint_states = topic_joint_states
        group = ReentrantCallbackGroup()

        def publisher(kind: Any, name: str) -> Any:
            topic = f"{self.ns}/commands/{name}"
            return self.robot_node.create_publisher(kind, topic, 10, callback_group=group)

        for attribute, (name, kind) in SERVICES.items():
            client = self.robot_node.create_client(kind, f"{self.ns}/{name}", callback_group=group)
            setattr(self, attribute, client)
        while not self.srv_set_op_modes.wait_for_service(timeout_sec=5.0) and rclpy.ok():
            self.robot_node.logerror(
                f"Failed to find services under namespace '{self.ns}'. Is the xs_sdk running "
                "under that namespace?"
            )
        for attribute in [*SERVICES][1:]:
            getattr(self, attribute).wait_for_service()
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
        self._index_joints()
        self.robot_node.loginfo(
            f"\n\tRobot Name: {self.robot_name}\n\tRobot Model: {self.robot_model}"
        )
        self.robot_node.loginfo("Initialized InterbotixRobotXSCore!")

    def get_node(self) -> InterbotixRobotNode:
        """Return the node that the interface is on."""
        return self.robot_node

    def __getattr__(self, name: str) -> Any:
        node = self.__dict__.get("robot_node")
        if node is None or name.startswith("_") or not hasattr(node, name):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return getattr(node, name)

    def robot_spin_once_until_future_complete(self, future: Any, timeout_sec: float = 0.1) -> None:
        """Wait for a future [s]; of the first release for ROS 2."""
        self.robot_node.wait_until_future_complete(future, timeout_sec)

    def robot_spin_until_future_complete(
        self, future: Any, timeout_sec: float | None = None
    ) -> None:
        """Wait for a future [s], without a timeout for ever; of the first release for ROS 2."""
        self.robot_node.wait_until_future_complete(future, timeout_sec)

    def _ask(self, service: Any, **request: Any) -> Any:
        future = service.call_async(service.srv_type.Request(**request))
        self.robot_node.wait_until_future_complete(future)
        return future.result()

    def _duration(self, seconds: float) -> Any:
        return Duration(seconds=seconds).to_msg()

    def _now(self) -> Any:
        return self.robot_node.get_clock().now().to_msg()

    def _sleep(self, duration: float) -> None:
        self.robot_node.get_clock().sleep_for(Duration(nanoseconds=int(duration * 1e9)))

    def _warn(self, message: str) -> None:
        self.robot_node.logwarn(message)

    def robot_get_motor_registers(self, cmd_type: str, name: str, reg: str) -> Any:
        """Return the values of a register."""
        return super().robot_get_motor_registers(cmd_type, name, reg).values

    def robot_write_trajectory(
        self,
        cmd_type: str,
        name: str,
        traj_type: str,
        raw_traj: Sequence[Mapping[float, Sequence[float]]],
    ) -> None:
        """Command waypoints: one mapping each from the time [s] to positions or velocities."""
        self._write_trajectory(cmd_type, name, traj_type, raw_traj)
