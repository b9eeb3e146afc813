"""A pan-and-tilt mechanism (ROS 1)."""

from __future__ import annotations

from ._turret import TurretInterface
from .core import InterbotixRobotXSCore

__all__ = ["InterbotixTurretXS", "InterbotixTurretXSInterface"]


class InterbotixTurretXS:
    """A turret by its model: `dxl` the driver, `turret` its interface."""

    def __init__(
        self,
        robot_model: str,
        robot_name: str | None = None,
        group_name: str = "turret",
        pan_profile_type: str = "time",
        pan_profile_velocity: float = 2.0,
        pan_profile_acceleration: float = 0.3,
        tilt_profile_type: str = "time",
        tilt_profile_velocity: float = 2.0,
        tilt_profile_acceleration: float = 0.3,
        init_node: bool = True,
    ) -> None:
        self.dxl = InterbotixRobotXSCore(robot_model, robot_name, init_node)
        self.turret = InterbotixTurretXSInterface(
            self.dxl,
            group_name,
            pan_profile_type,
            pan_profile_velocity,
            pan_profile_acceleration,
            tilt_profile_type,
            tilt_profile_velocity,
            tilt_profile_acceleration,
        )


class InterbotixTurretXSInterface(TurretInterface):
    """Turns and tilts what is mounted on it."""

    def __init__(
        self,
        core: InterbotixRobotXSCore,
        group_name: str = "turret",
        pan_profile_type: str = "time",
        pan_profile_velocity: float = 2.0,
        pan_profile_acceleration: float = 0.3,
        tilt_profile_type: str = "time",
        tilt_profile_velocity: float = 2.0,
        tilt_profile_acceleration: float = 0.3,
    ) -> None:
        self.core, self.group_name = core, group_name
        pan = pan_profile_type, pan_profile_velocity, pan_profile_acceleration
        tilt = tilt_profile_type, tilt_profile_velocity, tilt_profile_acceleration
        self._begin((pan, tilt))
        print("Initialized InterbotixTurretXSInterface!\n")  # noqa: T201
