"""The driver of a robot over the graph (ROS 1)."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import rospy
from interbotix_xs_msgs.msg import JointGroupCommand, JointSingleCommand, JointTrajectoryCommand
from sensor_msgs.msg import JointState

from ._core import SERVICES, RobotCore

__all__ = ["InterbotixRobotXSCore"]


class InterbotixRobotXSCore(RobotCore):
    """Calls the driver's services, publishes its commands and keeps its joint states."""

    def __init__(
        self,
        robot_model: str,
        robot_name: str | None = None,
        init_node: bool = True,
        joint_state_topic: str = "joint_states",
    ) -> None:
        super().__init__(robot_model, robot_name)
        if init_node:
            rospy.init_node(self.robot_name + "_robot_manipulation")
        space = f"/{self.robot_name}/"
        try:
            for name, _ in SERVICES.values():
                rospy.wait_for_service(space + name, timeout=5.0)
        except rospy.exceptions.ROSException as error:
            rospy.logerr(
                f"{error} The robot '{self.robot_name}' is not discoverable. Did you enter the "
                "correct robot_name parameter? Is the xs_sdk node running? Quitting..."
            )
            sys.exit(1)
        for attribute, (name, kind) in SERVICES.items():
            setattr(self, attribute, rospy.ServiceProxy(space + name, kind))
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
        self._index_joints()
        rospy.sleep(0.5)
        print(f"Robot Name: {self.robot_name}\nRobot Model: {robot_model}")  # noqa: T201
        print("Initialized InterbotixRobotXSCore!\n")  # noqa: T201

    def robot_write_trajectory(
        self,
        cmd_type: str,
        name: str,
        type: str,
        raw_traj: Sequence[Mapping[float, Sequence[float]]],
    ) -> None:
        """Command waypoints: one mapping each from the time [s] to positions or velocities."""
        self._write_trajectory(cmd_type, name, type, raw_traj)

    def joint_state_cb(self, msg: Any) -> None:
        """Keep the last joint states."""
        self._joint_state_cb(msg)

    def _ask(self, service: Any, **request: Any) -> Any:
        return service(**request)

    def _duration(self, seconds: float) -> Any:
        return rospy.Duration.from_sec(seconds)

    def _now(self) -> Any:
        return rospy.Time.now()

    def _sleep(self, duration: float) -> None:
        rospy.sleep(duration)

    def _warn(self, message: str) -> None:
        rospy.logwarn(message)
