"""What the interface of a pan-and-tilt mechanism does in either ROS."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Profile = tuple[str, float, float]
"""`time` or `velocity`, and the profile's velocity and acceleration: in [s], or in registers."""


class TurretInterface:
    """Commands the two servos of a group, each with a profile of its own."""

    core: Any
    group_name: str
    info: dict[str, dict[str, Any]]

    def _begin(self, profiles: tuple[Profile, Profile]) -> None:
        group = self.core.robot_get_robot_info("group", self.group_name)
        self.pan_name, self.tilt_name = group.joint_names[:2]
        self.info = {}
        limits = zip(group.joint_lower_limits, group.joint_upper_limits, strict=True)
        for name, (lower, upper), profile in zip(group.joint_names, limits, profiles, strict=False):
            place = self.core.js_index_map[name]
            self.info[name] = {
                "command": self.core.robot_get_joint_states().position[place],
                "lower_limit": lower,
                "upper_limit": upper,
            }
            self.change_profile(name, *profile)

    def change_profile(
        self,
        joint_name: str,
        profile_type: str,
        profile_velocity: float,
        profile_acceleration: float,
    ) -> None:
        """Set how a joint takes its commands."""
        self.info[joint_name].update(
            profile_type=profile_type,
            profile_velocity=profile_velocity,
            profile_acceleration=profile_acceleration,
        )
        self.core.robot_set_operating_modes(
            "single",
            joint_name,
            "position",
            "velocity" if profile_type == "velocity" else "time",
            self._register(joint_name, profile_velocity),
            self._register(joint_name, profile_acceleration),
        )

    def _register(self, joint_name: str, value: float) -> int:
        is_time = self.info[joint_name]["profile_type"] != "velocity"
        return int(value * 1000) if is_time else int(value)

    def set_trajectory_profile(
        self,
        joint_name: str,
        profile_velocity: float | None = None,
        profile_acceleration: float | None = None,
    ) -> None:
        """Set the registers of a joint's profile; without a value one stays as it is."""
        asked = {"velocity": profile_velocity, "acceleration": profile_acceleration}
        for name, value in asked.items():
            if value is not None and value != self.info[joint_name][f"profile_{name}"]:
                self.core.robot_set_motor_registers(
                    "single",
                    joint_name,
                    f"Profile_{name.capitalize()}",
                    self._register(joint_name, value),
                )
                self.info[joint_name][f"profile_{name}"] = value

    def _is_within(self, asked: Mapping[str, float]) -> bool:
        return all(
            self.info[name]["lower_limit"] <= position <= self.info[name]["upper_limit"]
            for name, position in asked.items()
        )

    def _wait(self, names: tuple[str, ...], blocking: bool, delay: float) -> None:
        profiles = [self.info[name] for name in names]
        if blocking and all(profile["profile_type"] == "time" for profile in profiles):
            delay = max(profile["profile_velocity"] for profile in profiles)
        self.core._sleep(delay)

    def move(
        self,
        joint_name: str,
        position: float,
        profile_velocity: float | None = None,
        profile_acceleration: float | None = None,
        blocking: bool = True,
        delay: float = 0,
    ) -> None:
        """Move one joint [rad]; beyond its limits nothing moves."""
        if not self._is_within({joint_name: position}):
            self.core._warn(f"Goal position is outside the {joint_name} joint's limits.")
            return
        self.set_trajectory_profile(joint_name, profile_velocity, profile_acceleration)
        self.core.robot_write_joint_command(joint_name, float(position))
        self.info[joint_name]["command"] = position
        self._wait((joint_name,), blocking, delay)

    def pan(self, position: float, *args: Any, **more: Any) -> None:
        """Turn [rad]; the other arguments are those of `move`."""
        self.move(self.pan_name, position, *args, **more)

    def tilt(self, position: float, *args: Any, **more: Any) -> None:
        """Tilt [rad]; the other arguments are those of `move`."""
        self.move(self.tilt_name, position, *args, **more)

    def pan_tilt_go_home(self, *args: Any, **more: Any) -> None:
        """Bring both joints to 0; the arguments are those of `pan_tilt_move`."""
        self.pan_tilt_move(0, 0, *args, **more)

    def pan_tilt_move(
        self,
        pan_position: float,
        tilt_position: float,
        pan_profile_velocity: float | None = None,
        pan_profile_acceleration: float | None = None,
        tilt_profile_velocity: float | None = None,
        tilt_profile_acceleration: float | None = None,
        blocking: bool = True,
        delay: float = 0,
    ) -> None:
        """Move both joints [rad] at once; beyond a limit nothing moves."""
        asked = {self.pan_name: pan_position, self.tilt_name: tilt_position}
        if not self._is_within(asked):
            self.core._warn("One or both goal positions are outside the limits!")
            return
        self.set_trajectory_profile(self.pan_name, pan_profile_velocity, pan_profile_acceleration)
        self.set_trajectory_profile(
            self.tilt_name, tilt_profile_velocity, tilt_profile_acceleration
        )
        self.core.robot_write_commands(self.group_name, [float(value) for value in asked.values()])
        for name, position in asked.items():
            self.info[name]["command"] = position
        self._wait(tuple(asked), blocking, delay)

    def get_command(self, joint_name: str) -> float:
        """Return the position last commanded of a joint [rad]."""
        return float(self.info[joint_name]["command"])

    def get_joint_commands(self) -> list[float]:
        """Return the positions last commanded [rad]."""
        return [self.get_command(self.pan_name), self.get_command(self.tilt_name)]
