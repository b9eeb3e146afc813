"""A pan-and-tilt mechanism (ROS 2)."""

from __future__ import annotations

from threading import Thread
from typing import Any

import rclpy
from rclpy.executors import MultiThreadedExecutor
from rclpy.logging import LoggingSeverity

from .._turret import TurretInterface
from .core import InterbotixRobotXSCore

__all__ = ["InterbotixTurretXS", "InterbotixTurretXSInterface"]


class InterbotixTurretXS:
    """A turret by its model: `core` the driver, `turret` its interface."""

    def __init__(
        self,
        robot_model: str,
        robot_name: str | None = None,
        turret_name: str = "turret",
        pan_profile_type: str = "time",
        pan_profile_velocity: float = 2.0,
        pan_profile_acceleration: float = 0.3,
        tilt_profile_type: str = "time",
        tilt_profile_velocity: float = 2.0,
        tilt_profile_acceleration: float = 0.3,
        logging_level: Any = LoggingSeverity.INFO,
        node_name: str = "robot_manipulation",
        start_on_init: bool = True,
    ) -> None:
        self.core = InterbotixRobotXSCore(
            robot_model, robot_name, logging_level=logging_level, node_name=node_name
        )
        self.turret = InterbotixTurretXSInterface(
            self.core,
            turret_name,
            pan_profile_type,
            pan_profile_velocity,
            pan_profile_acceleration,
            tilt_profile_type,
            tilt_profile_velocity,
            tilt_profile_acceleration,
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


class InterbotixTurretXSInterface(TurretInterface):
    """Turns and tilts what is mounted on it."""

    def __init__(
        self,
        core: InterbotixRobotXSCore,
        turret_name: str = "turret",
        pan_profile_type: str = "time",
        pan_profile_velocity: float = 2.0,
        pan_profile_acceleration: float = 0.3,
        tilt_profile_type: str = "time",
        tilt_profile_velocity: float = 2.0,
        tilt_profile_acceleration: float = 0.3,
    ) -> None:
        self.core, self.turret_name = core, turret_name
        self.group_name = turret_name
        pan = pan_profile_type, pan_profile_velocity, pan_profile_acceleration
        tilt = tilt_profile_type, tilt_profile_velocity, tilt_profile_acceleration
        self._begin((pan, tilt))
        core.get_node().loginfo("Initialized InterbotixTurretXSInterface!")
