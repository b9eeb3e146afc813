"""A gripper (ROS 2)."""

from __future__ import annotations

from threading import Thread
from typing import Any

import rclpy
from rclpy.executors import MultiThreadedExecutor
from rclpy.logging import LoggingSeverity

from .._gripper import GripperInterface
from .core import InterbotixRobotXSCore

__all__ = ["InterbotixGripperXS", "InterbotixGripperXSInterface"]


class InterbotixGripperXS:
    """A gripper without its arm: `core` the driver, `gripper` its interface."""

    def __init__(
        self,
        robot_model: str,
        gripper_name: str,
        robot_name: str | None = None,
        gripper_pressure: float = 0.5,
        gripper_pressure_lower_limit: int = 150,
        gripper_pressure_upper_limit: int = 350,
        topic_joint_states: str = "joint_states",
        logging_level: Any = LoggingSeverity.INFO,
        node_name: str = "robot_manipulation",
        start_on_init: bool = True,
    ) -> None:
        self.core = InterbotixRobotXSCore(
            robot_model,
            robot_name,
            topic_joint_states=topic_joint_states,
            logging_level=logging_level,
            node_name=node_name,
        )
        self.gripper = InterbotixGripperXSInterface(
            self.core,
            gripper_name,
            gripper_pressure,
            gripper_pressure_lower_limit,
            gripper_pressure_upper_limit,
        )
        if start_on_init:
            self.start()

    def start(self) -> None:
        """Spin on a thread of its own."""
        self._execution_thread = Thread(target=self.run, daemon=True)
        self._execution_thread.start()

    def run(self) -> None:
        """Spin until ROS is shut down."""
        self.ex = MultiThreadedExecutor()
        self.ex.add_node(self.core.get_node())
        self.ex.spin()

    def shutdown(self) -> None:
        """Destroy the node and shut ROS down."""
        self.core.get_node().destroy_node()
        rclpy.shutdown()
        self._execution_thread.join()


class InterbotixGripperXSInterface(GripperInterface):
    """Grasps and releases with a pressure."""

    def __init__(
        self,
        core: InterbotixRobotXSCore,
        gripper_name: str,
        gripper_pressure: float = 0.5,
        gripper_pressure_lower_limit: int = 150,
        gripper_pressure_upper_limit: int = 350,
    ) -> None:
        self.core = core
        self.gripper_name = gripper_name
        self.gripper_pressure = gripper_pressure
        self._begin(
            gripper_name,
            gripper_pressure,
            gripper_pressure_lower_limit,
            gripper_pressure_upper_limit,
        )
        self.gripper_info = core.robot_get_robot_info("single", gripper_name)
        self._take_info(self.gripper_info)
        node = core.get_node()
        if self.gripper_info.mode not in ("current", "pwm"):
            node.logwarn(f"Motor '{gripper_name}' operating mode not set to 'pwm' or 'current'.")
        self.tmr_gripper_state = node.create_timer(0.02, self.gripper_state)
        core._sleep(0.5)
        node.loginfo(
            f"\n\tGripper Name: {gripper_name}\n\tGripper Pressure: {gripper_pressure * 100}%"
        )
        node.loginfo("Initialized InterbotixGripperXSInterface!")

    def gripper_state(self) -> None:
        """Stop fingers that are at their limit."""
        self._look()

    def release(self, delay: float = 1.0) -> None:
        """Open the gripper and wait [s]."""
        self.gripper_controller(self.gripper_value, delay)

    def grasp(self, delay: float = 1.0) -> None:
        """Close the gripper and wait [s]."""
        self.gripper_controller(-self.gripper_value, delay)

    def get_gripper_position(self) -> float:
        """Return the angle of the gripper's servo [rad]."""
        return self._servo("position")

    def get_gripper_velocity(self) -> float:
        """Return the speed of the gripper's servo [rad/s]."""
        return self._servo("velocity")

    def get_gripper_effort(self) -> float:
        """Return the effort of the gripper's servo."""
        return self._servo("effort")

    def get_finger_position(self) -> float:
        """Return how far the left finger is from the middle [m]."""
        return self._finger()

    def _servo(self, field: str) -> float:
        with self.core.js_mutex:
            values = getattr(self.core.joint_states, field)
            return float(values[self.core.js_index_map[self.gripper_name]])
