"""The servos of an Interbotix arm: operating modes, profiles, registers, the gripper's linkage.

Source of units and tables: the ROBOTIS e-Manual of the X series (protocol 2.0); of the linkage and
the modes at the start: Interbotix/interbotix_ros_core xs_sdk and interbotix_ros_manipulators
interbotix_xsarm_control/config (modes.yaml and one file for each arm).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from tracerisk.ros.robot.motion_profiles import Ramp, ramp_of_speed

MODES = (
    "position",
    "ext_position",
    "velocity",
    "current",
    "current_based_position",
    "linear_position",
    "pwm",
)
SPEED_UNIT = 0.229 * 2 * math.pi / 60
"""One unit of Profile_Velocity [rad/s]."""
ACCELERATION_UNIT = 214.577 * 2 * math.pi / 3600
"""One unit of Profile_Acceleration [rad/s^2]."""
LARGEST = {"pwm": 885.0, "current": 1193.0}
"""The commands of full effort: 100 % of the supply, and the current limit in units of 2.69 mA."""

# What can be set and is kept, without an effect on the simulated servo but for the profiles.
SETTINGS = frozenset(
    {
        "Return_Delay_Time", "Drive_Mode", "Homing_Offset", "Moving_Threshold",
        "Temperature_Limit", "Max_Voltage_Limit", "Min_Voltage_Limit", "PWM_Limit",
        "Current_Limit", "Velocity_Limit", "Max_Position_Limit", "Min_Position_Limit", "Shutdown",
        "LED", "Status_Return_Level", "Velocity_I_Gain", "Velocity_P_Gain", "Position_D_Gain",
        "Position_I_Gain", "Position_P_Gain", "Feedforward_2nd_Gain", "Feedforward_1st_Gain",
        "Profile_Velocity", "Profile_Acceleration",
    }
)  # fmt: skip


@dataclass(slots=True, eq=False)
class Servo:
    """The settings of one servo."""

    mode: str = "position"
    """The operating mode, one of `MODES`."""
    profile_type: str = "time"
    """The meaning of the profile registers: `time` or `velocity`."""
    torque: bool = True
    """Whether its torque is on."""
    registers: dict[str, int] = field(
        default_factory=lambda: {"Profile_Velocity": 2000, "Profile_Acceleration": 300}
    )
    """The values of the registers that were set, in the units of the e-Manual."""

    def ramp(self, way: float, speed: float, acceleration: float) -> Ramp:
        """Return how the servo goes a way; `speed` and `acceleration` are the most it can.

        In a profile of time both registers are milliseconds, and no speed but the servo's own
        keeps it from being there in time; in one of velocity they are speeds, 0 for no limit.
        """
        fastest = ramp_of_speed(way, speed, acceleration)
        asked, rise = self.registers["Profile_Velocity"], self.registers["Profile_Acceleration"]
        if self.profile_type == "time":
            return Ramp(asked / 1000, rise / 1000) if asked > 0 else fastest
        return ramp_of_speed(
            way,
            min(asked * SPEED_UNIT, speed) if asked > 0 else speed,
            rise * ACCELERATION_UNIT if rise > 0 else acceleration,
        )

    @property
    def is_positional(self) -> bool:
        """Whether its commands are positions."""
        return "position" in self.mode


@dataclass(frozen=True, slots=True)
class Linkage:
    """The horn and the arm between a gripper's servo and a finger."""

    horn: float
    """The length of the horn [m]."""
    arm: float
    """The length of the arm [m]."""

    def finger(self, angle: float) -> float:
        """Return how far a finger is from the middle [m] with the horn at an angle [rad]."""
        return self.horn * math.sin(angle) + math.sqrt(
            self.arm**2 - (self.horn * math.cos(angle)) ** 2
        )

    def angle(self, finger: float) -> float:
        """Return the angle of the horn [rad] for a finger's distance from the middle [m]."""
        cosine = (self.horn**2 + finger**2 - self.arm**2) / (2 * self.horn * finger)
        return math.pi / 2 - math.acos(min(max(cosine, -1.0), 1.0))


_SMALL, _LARGE = Linkage(0.014, 0.024), Linkage(0.022, 0.036)


def linkage_of(robot: str) -> Linkage:
    """Return the linkage of an arm by its model."""
    return _LARGE if robot.startswith("vx300") else _SMALL
