"""A point of a way, and how fast it is gone to."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from typing import Any

from geometry_msgs.msg import PoseStamped
from intera_interface import Limb
from intera_motion_msgs.msg import Waypoint, WaypointOptions

__all__ = ["MotionWaypoint", "MotionWaypointOptions"]

_DEFAULT_ANGLES = (0.0, -0.9, 0.0, 1.8, 0.0, -0.9, 0.0)
_TIP = "right_hand"


class MotionWaypointOptions:
    """Makes the message of speeds, accelerations and tolerances."""

    default_speed_ratio = 0.7
    default_joint_tolerance = 0.05
    default_max_linear_speed = 0.6
    default_max_linear_accel = 0.6
    default_max_rot_speed = 1.57
    default_max_rot_accel = 1.57

    def __init__(
        self,
        n_dim: int = 7,
        max_joint_speed_ratio: float | None = None,
        joint_tolerances: float | Sequence[float] | None = None,
        max_linear_speed: float | None = None,
        max_linear_accel: float | None = None,
        max_rotational_speed: float | None = None,
        max_rotational_accel: float | None = None,
        max_joint_accel: float | Sequence[float] | None = None,
        label: str = "default",
        corner_distance: float = 0.0,
    ) -> None:
        self._n_dim = n_dim
        self._data = WaypointOptions(label=label)
        self.set_max_joint_speed_ratio(max_joint_speed_ratio)
        self.set_joint_tolerances(joint_tolerances)
        self.set_max_linear_speed(max_linear_speed)
        self.set_max_linear_accel(max_linear_accel)
        self.set_max_rotational_speed(max_rotational_speed)
        self.set_max_rotational_accel(max_rotational_accel)
        self.set_max_joint_accel(max_joint_accel)
        self.set_corner_distance(corner_distance)

    def set_max_joint_speed_ratio(self, speed_ratio: float | None = None) -> None:
        """Set the fraction of the joints' speed, from 0.05 to 1."""
        asked = self.default_speed_ratio if speed_ratio is None else speed_ratio
        self._data.max_joint_speed_ratio = min(max(float(asked), 0.05), 1.0)

    def set_joint_tolerances(self, tol: float | Sequence[float] | None = None) -> None:
        """Set how far each joint may be from the point [rad]."""
        asked = self.default_joint_tolerance if tol is None else tol
        self._data.joint_tolerances = self._each(asked)

    def set_max_joint_accel(self, max_joint_accel: float | Sequence[float] | None = None) -> None:
        """Set the accelerations of the joints [rad/s^2]; without a value the controller's own."""
        self._data.max_joint_accel = [] if max_joint_accel is None else self._each(max_joint_accel)

    def _each(self, asked: float | Sequence[float]) -> list[float]:
        if isinstance(asked, int | float):
            return [float(asked)] * self._n_dim
        return [float(value) for value in asked]

    def set_max_linear_speed(self, speed: float | None = None) -> None:
        """Set the speed of the tip [m/s]."""
        self._data.max_linear_speed = self.default_max_linear_speed if speed is None else speed

    def set_max_linear_accel(self, accel: float | None = None) -> None:
        """Set the acceleration of the tip [m/s^2]."""
        self._data.max_linear_accel = self.default_max_linear_accel if accel is None else accel

    def set_max_rotational_speed(self, speed: float | None = None) -> None:
        """Set how fast the tip turns [rad/s]."""
        self._data.max_rotational_speed = self.default_max_rot_speed if speed is None else speed

    def set_max_rotational_accel(self, accel: float | None = None) -> None:
        """Set the angular acceleration of the tip [rad/s^2]."""
        self._data.max_rotational_accel = self.default_max_rot_accel if accel is None else accel

    def set_label(self, label: str = "default") -> None:
        """Set the name of the options."""
        self._data.label = label

    def set_corner_distance(self, corner_distance: float | None = None) -> None:
        """Set how far from the point the way may turn off [m]."""
        self._data.corner_distance = min(max(float(corner_distance or 0.0), 0.0), 0.5)

    def to_msg(self) -> Any:
        """Return the options as WaypointOptions."""
        return deepcopy(self._data)


class MotionWaypoint:
    """Makes the message of a point: joint angles, or the pose of a tip."""

    def __init__(
        self,
        joint_angles: Sequence[float] | None = (),
        active_endpoint: str | None = None,
        options: Any = None,
        limb: Any = None,
    ) -> None:
        self._data = Waypoint()
        self._limb = Limb() if limb is None else limb
        self.set_joint_angles(joint_angles, active_endpoint)
        self.set_waypoint_options(options)

    @staticmethod
    def get_default_joint_angles() -> list[float]:
        """Return the angles of a point for which none are given [rad]."""
        return list(_DEFAULT_ANGLES)

    @staticmethod
    def get_default_active_endpoint() -> str:
        """Return the tip that is meant where none is named."""
        return _TIP

    def set_from_message(self, wpt_msg: Any) -> None:
        """Take a Waypoint as it is."""
        self._data = deepcopy(wpt_msg)

    def set_waypoint_options(self, options: Any = None) -> None:
        """Set the options, as WaypointOptions or what makes these."""
        if options is None:
            options = MotionWaypointOptions()
        is_maker = isinstance(options, MotionWaypointOptions)
        self._data.options = options.to_msg() if is_maker else deepcopy(options)

    def get_joint_angles(self) -> list[float]:
        """Return the joint angles [rad]; none for a point that is a pose."""
        return list(self._data.joint_positions)

    def set_angles_from_joint_state(self, joint_state: Any) -> None:
        """Take the positions of a JointState for the joint angles."""
        self.set_joint_angles(joint_state.position)

    def set_joint_angles(
        self,
        joint_angles: Sequence[float] | None = (),
        active_endpoint: str | None = None,
        perform_fk: bool = False,
    ) -> None:
        """Set the joint angles [rad], and with `perform_fk` the pose that they lead to."""
        angles = list(_DEFAULT_ANGLES if joint_angles is None else joint_angles)
        tip = active_endpoint or _TIP
        pose = PoseStamped()
        if perform_fk and angles:
            by_name = dict(zip(self._limb.joint_names(), angles, strict=False))
            pose.pose = self._limb.joint_angles_to_cartesian_pose(by_name, tip)
        self._data.pose, self._data.joint_positions = pose, angles
        self._data.active_endpoint = tip

    def set_cartesian_pose(
        self,
        pose: Any = None,
        active_endpoint: str | None = None,
        joint_angles: Sequence[float] | None = (),
    ) -> None:
        """Set the pose of a tip, a PoseStamped; the joint angles are those to stay near to."""
        self._data.pose = PoseStamped() if pose is None else pose
        self._data.joint_positions = list(joint_angles or ())
        self._data.active_endpoint = active_endpoint or _TIP

    def to_msg(self) -> Any:
        """Return the point as a Waypoint."""
        return deepcopy(self._data)

    def to_string(self) -> str:
        """Return the point as text."""
        return str(self._data)
