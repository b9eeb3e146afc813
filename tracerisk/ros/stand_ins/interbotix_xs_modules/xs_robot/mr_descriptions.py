"""Screw axes and home poses of the arms; see `interbotix_xs_modules.mr_descriptions`."""

from ..mr_descriptions import (
    ModernRoboticsDescription,
    aloha_vx300s,
    aloha_wx250s,
    mobile_px100,
    mobile_wx200,
    mobile_wx250s,
    px100,
    px150,
    rx150,
    rx200,
    vx250,
    vx300,
    vx300s,
    wx200,
    wx250,
    wx250s,
)

__all__ = [
    "ModernRoboticsDescription",
    "aloha_vx300s",
    "aloha_wx250s",
    "mobile_px100",
    "mobile_wx200",
    "mobile_wx250s",
    "px100",
    "px150",
    "rx150",
    "rx200",
    "vx250",
    "vx300",
    "vx300s",
    "wx200",
    "wx250",
    "wx250s",
]
