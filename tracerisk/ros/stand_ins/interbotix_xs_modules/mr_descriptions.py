"""Screw axes and home poses of the arms, in the manner of "Modern Robotics".

Source of the lengths: Interbotix/interbotix_ros_toolboxes, interbotix_xs_modules/mr_descriptions.
The space frame is `base_link`, the end effector `ee_gripper_link`.
"""

from __future__ import annotations

from abc import ABC
from typing import Any

import numpy as np

from tracerisk.ros.imports.exported import defined as _defined


class ModernRoboticsDescription(ABC):  # noqa: B024 - so is the library's
    """The screw axes `Slist` (6, n) and the home pose `M` (4, 4) of an arm."""

    Slist: Any = None
    M: Any = None


# Which axes an arm has, from its base: waist, shoulder, elbow, [forearm roll,] wrist[, roll].
_FOUR, _FIVE, _SIX = "zyyy", "zyyyx", "zyyxyx"


def _arm(
    name: str, axes: str, shoulder: float, elbow: float, forearm: float, wrist: float, tip: float
) -> Any:
    """Return the class of an arm.

    Lengths in [m]: the heights of shoulder and elbow, and how far elbow, wrist and tip are ahead
    of the base, with the arm stretched out level from the elbow.
    """
    pitches = iter([(-shoulder, 0.0), (-elbow, forearm), (-elbow, wrist)])
    screws = []
    for axis in axes:
        if axis == "z":
            screws.append([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        elif axis == "x":
            screws.append([1.0, 0.0, 0.0, 0.0, elbow, 0.0])
        else:
            height, ahead = next(pitches)
            screws.append([0.0, 1.0, 0.0, height, 0.0, ahead])
    home = np.identity(4)
    home[:3, 3] = [tip, 0.0, elbow]
    body = {
        "Slist": np.array(screws).T,
        "M": home,
        "__module__": __name__,
        "__doc__": f"The arm {name}.",
    }
    return type(name, (ModernRoboticsDescription,), body)


px100 = _arm("px100", _FOUR, 0.0931, 0.1931, 0.035, 0.135, 0.248575)
px150 = _arm("px150", _FIVE, 0.10457, 0.25457, 0.05, 0.2, 0.358575)
rx150 = _arm("rx150", _FIVE, 0.10457, 0.25457, 0.05, 0.2, 0.358575)
rx200 = _arm("rx200", _FIVE, 0.10457, 0.30457, 0.05, 0.25, 0.408575)
vx250 = _arm("vx250", _FIVE, 0.12705, 0.37705, 0.06, 0.31, 0.468575)
vx300 = _arm("vx300", _FIVE, 0.12705, 0.42705, 0.05955, 0.35955, 0.536494)
vx300s = _arm("vx300s", _SIX, 0.12705, 0.42705, 0.05955, 0.35955, 0.536494)
wx200 = _arm("wx200", _FIVE, 0.11065, 0.31065, 0.05, 0.25, 0.408575)
wx250 = _arm("wx250", _FIVE, 0.11065, 0.36065, 0.04975, 0.29975, 0.458325)
wx250s = _arm("wx250s", _SIX, 0.11065, 0.36065, 0.04975, 0.29975, 0.458325)
mobile_px100 = _arm("mobile_px100", _FOUR, 0.08518, 0.18518, 0.035, 0.135, 0.248575)
mobile_wx200 = _arm("mobile_wx200", _FIVE, 0.104825, 0.304825, 0.05, 0.25, 0.408575)
mobile_wx250s = _arm("mobile_wx250s", _SIX, 0.104825, 0.354825, 0.04975, 0.29975, 0.458325)
aloha_wx250s = _arm("aloha_wx250s", _SIX, 0.104825, 0.354825, 0.04975, 0.29975, 0.458325)
aloha_vx300s = _arm("aloha_vx300s", _SIX, 0.12705, 0.42705, 0.05955, 0.35955, 0.536494)


__all__ = _defined(globals())
