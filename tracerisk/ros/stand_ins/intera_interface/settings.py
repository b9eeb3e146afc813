"""Tolerances and versions of the SDK."""

JOINT_ANGLE_TOLERANCE = 0.008726646
"""Half a degree [rad]."""
HEAD_PAN_ANGLE_TOLERANCE = 0.1396263401
"""Eight degrees [rad]."""
SDK_VERSION = "5.3.0"
CHECK_VERSION = True
VERSIONS_SDK2ROBOT = {"5.3.0": ["5.3.0"]}
VERSIONS_SDK2GRIPPER = {"5.3.0": {"warn": "2014/5/20 00:00:00", "fail": "2013/10/15 00:00:00"}}
