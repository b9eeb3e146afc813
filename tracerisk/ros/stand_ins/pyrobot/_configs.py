"""What the library is configured with, by part; its values are those of its nodes.

facebookresearch/pyrobot src/pyrobot/cfg: config.py, locobot_config.py, sawyer_config.py,
ur5_config.py.
"""

from __future__ import annotations

from copy import deepcopy
from typing import Any


class Config(dict[str, Any]):
    """Values by name, as keys and as attributes."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value

    def clone(self) -> Config:
        """Return a copy, all the way down."""
        return deepcopy(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> Config:
        return Config({name: deepcopy(value, memo) for name, value in self.items()})


_ARM: dict[str, Any] = {
    "ARM_ROBOT_DSP_PARAM_NAME": "/robot_description",
    "IK_POSITION_TOLERANCE": 0.01,
    "IK_ORIENTATION_TOLERANCE": 0.1,
    "MAX_JOINT_ERROR": 0.09,
    "MAX_EE_ERROR": 0.03,
    "WAIT_MIN_TIME": 0.05,
    "ROSTOPIC_JOINT_STATES": "/joint_states",
    "ROSSRV_CART_PATH": "/compute_cartesian_path",
    "ROSSRV_MP_PATH": "/plan_kinematic_path",
}
_FINE: dict[str, Any] = {"IK_POSITION_TOLERANCE": 0.005, "IK_ORIENTATION_TOLERANCE": 0.005}
_ARMS: dict[str, dict[str, Any]] = {
    "locobot": {},
    "sawyer": _FINE,
    "ur5": {**_FINE, "ARM_MAX_JOINT_VELOCITY": 0.6},
}
_BASE: dict[str, Any] = {
    "BASE_TYPE": "kobuki",
    "BASE_CONTROLLER": "ilqr",
    "BASE_PLANNER": "movebase",
    "ROSTOPIC_BASE_COMMAND": "/navigation_velocity_smoother/raw_cmd_vel",
    "ROSTOPIC_ODOMETRY": "/odom",
    "ROSTOPIC_BUMPER": "/mobile_base/events/bumper",
    "ROSTOPIC_CLIFF": "/mobile_base/events/cliff",
    "ROSTOPIC_WHEELDROP": "/mobile_base/events/wheel_drop",
    "MAP_FRAME": "map",
    "BASE_CONTROL_RATE": 10,
    "MAX_ABS_FWD_SPEED": 0.2,
    "MAX_ABS_TURN_SPEED": 0.5,
    "MAX_ABS_FWD_SPEED_P_CONTROLLER": 0.5,
    "MAX_ABS_TURN_SPEED_P_CONTROLLER": 1,
}
_CAMERA: dict[str, Any] = {
    "MIN_PAN": -2.7,
    "MAX_PAN": 2.6,
    "MIN_TILT": -1.4,
    "MAX_TILT": 1.75,
    "RESET_PAN": 0.0,
    "RESET_TILT": 0.0,
    "ROSTOPIC_CAMERA_INFO_STREAM": "/camera/color/camera_info",
    "ROSTOPIC_CAMERA_RGB_STREAM": "/camera/color/image_raw",
    "ROSTOPIC_CAMERA_DEPTH_STREAM": "/camera/aligned_depth_to_color/image_raw",
    "ROSTOPIC_SET_PAN": "/pan/command",
    "ROSTOPIC_SET_TILT": "/tilt/command",
    "DEPTH_MAP_FACTOR": 1000,
}
_GRIPPERS: dict[str, dict[str, Any]] = {
    "locobot": {
        "ROSTOPIC_GRIPPER_OPEN": "/gripper/open",
        "ROSTOPIC_GRIPPER_CLOSE": "/gripper/close",
        "ROSTOPIC_GRIPPER_STATE": "/gripper/state",
    },
    "sawyer": {"GRIPPER_MAX_POSITION": 0.041667, "GRIPPER_MIN_POSITION": 0.0},
    "ur5": {},
}


def config_of(kind: str) -> Config:
    """Return the configuration of a kind of robot: `locobot`, `sawyer` or `ur5`."""
    is_locobot = kind == "locobot"
    return Config(
        HAS_ARM=True,
        HAS_BASE=is_locobot,
        HAS_CAMERA=is_locobot,
        HAS_GRIPPER=kind != "ur5",
        ARM=Config(_ARM | _ARMS[kind]),
        BASE=Config(_BASE if is_locobot else {}),
        CAMERA=Config(_CAMERA if is_locobot else {}),
        GRIPPER=Config(_GRIPPERS[kind]),
    )
