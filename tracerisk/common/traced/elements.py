"""What one element of the robot did in a span of time, what it held and what it touched."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

ElementKind = Literal["joint", "gripper", "sensor", "contact", "component"]
SensorKind = Literal["encoder", "torque", "wrench", "camera"]
WEAR_EXPONENTS: tuple[float, ...] = (1.0, 2.0, 3.0, 10.0 / 3.0, 4.0, 6.0, 9.0)
"""The exponents k for which a run measures how load ages a drive, see `Exposure.wear`."""
GENTLE_N = 20.0
"""The normal force up to which a held thing may press on what bears it, twice its weight more.

Own choice: a servo of 2000 N m/rad half a metre away presses with 8 N for each millimetre that a
set-point lies below a surface, and in the shipped samples no held thing is pressed on with 3 N.
"""


@dataclass(frozen=True, slots=True, order=True)
class Element:
    """A part of the robot that the twin watches."""

    name: str
    """The joint, gripper, sensor, contact or component, unique in the trace."""
    kind: ElementKind
    """What sort of part it is; `component` only in a log of another tool."""
    sensor: SensorKind | None = None
    """What a sensor measures; `None` for all other elements."""
    part: str | None = None
    """The joint or link that a sensor is mounted on, or the link that touches; else `None`."""
    actuators: tuple[str, ...] = ()
    """The actuators that drive a joint or gripper, where the model names them separately."""


@dataclass(frozen=True, slots=True)
class Exposure:
    """What one element did over some span of time.

     `moving_s` and `holding_s` are disjoint, `grasping_s` may overlap either. An uninterrupted
    stretch that fills the span, or an unbroken part of it, counts from its begin to its end in the
    run. `travel_s` and `wear` add up over visits. Torque and speed are fractions of the rated ones.
    """

    moving_s: float = 0.0
    """The time in motion [s]."""
    holding_s: float = 0.0
    """The time at rest under a torque above the threshold [s]."""
    grasping_s: float = 0.0
    """The time with something grasped, or touched in the case of a contact [s]."""
    active_s: float = 0.0
    """The time in any of moving, holding or grasping [s]."""
    longest_moving_s: float = 0.0
    """The longest uninterrupted motion [s]."""
    longest_active_s: float = 0.0
    """The longest uninterrupted stretch of activity [s]."""
    starts: int = 0
    """The number of motions begun."""
    grasps: int = 0
    """The number of grasps closed."""
    torque_rms: float = 0.0
    """The root mean square of the torque over the active time, as a fraction of the limit."""
    torque_cubic: float = 0.0
    """The speed-weighted cubic mean of the torque over the moving time, as a fraction."""
    borderline: bool = False
    """Whether a deciding value lay within a factor of two of its threshold."""
    releases: int = 0
    """The number of grasps opened."""
    grasping_moving_s: float = 0.0
    """The time in which it moved and grasped at once [s]."""
    reading_s: float = 0.0
    """The time in which the controller read it, for a sensor [s]."""
    travel_s: float = 0.0
    """The time that the motion would take at rated speed: the integral of |v| over it [s]."""
    wear: tuple[float, ...] = ()
    """The integral of |v| L^k over the motion, v speed, L torque, k = `WEAR_EXPONENTS[i]` [s],
    (n_exponents,); empty where nothing moved."""


@dataclass(frozen=True, slots=True)
class Payload:
    """What a gripper held during a visit."""

    gripper: str
    """The gripper that held it, or the link that it was welded to."""
    object: str
    """The object's name in the scene."""
    mass_kg: float
    """The object's mass [kg]."""
    held_s: float
    """The time for which it was held in the visit [s]."""
    pad_force_n: float
    """The lesser of the forces on the two pads, averaged over the time held [N]."""
    most_pad_force_n: float
    """The greatest value of the same force [N]."""


@dataclass(frozen=True, slots=True)
class Contact:
    """A touch during a visit: a link of the robot, or a thing it holds, and another body."""

    link: str
    """The robot's link, or the object that it holds."""
    other: str
    """The body that was touched."""
    start_s: float
    """The simulated time at which the touch began [s]."""
    touching_s: float
    """The time for which it lasted within the visit [s]."""
    force_n: float
    """The greatest normal force [N]."""
    expected: bool
    """Whether the other body is grasped, or meant to be."""
    from_grasp_s: float | None = None
    """How long before (negative) or after its gripper holds the other body the touch is [s]:
    zero while it is held; `None` where it never is."""
