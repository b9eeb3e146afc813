"""Separate names that any robot's parts may have from those that identify one robot."""

from __future__ import annotations

import re

_PLAIN = frozenset({
    "action", "actuator", "angle", "arm", "arms", "axis", "bar", "base", "body", "both",
    "bracket", "camera", "cmd", "column", "command", "controller", "controllers", "drive",
    "dummy", "ee", "eef", "effector", "effort", "elbow", "end", "finger", "fingers", "fixed",
    "flange", "flex", "follow", "footprint", "forearm", "frame", "front", "ft", "grasping",
    "gripper", "grippers", "group", "half", "hand", "head", "inertia", "inner", "input", "j",
    "jaw", "jaws", "joint", "joints", "knuckle", "l", "left", "leftfinger", "lift", "limb",
    "link", "lower", "manipulator", "map", "mount", "mounting", "moving", "odom", "outer",
    "output", "pad", "palm", "pan", "part", "pitch", "plate", "pos", "position", "prop", "r",
    "revolute", "right", "rightfinger", "robot", "robotiq", "roll", "root", "rotate", "sensor",
    "shoulder", "state", "states", "tcp", "thumb", "tilt", "tip", "to", "tool", "torso", "traj",
    "trajectory", "twist", "upper", "upperarm", "vel", "velocity", "visual", "waist", "wheel",
    "with", "world", "wrist", "yaw",
})  # fmt: skip
_NUMBERED = frozenset({"axis", "j", "joint", "link"})


def is_plain(name: str) -> bool:
    """Return whether a name is made of words that any robot's parts may have: `elbow_joint`.

    A name of several levels (`/robot/limb/right`) is none.
    """
    return "/" not in name and _letters(name) <= _PLAIN


def is_number(name: str) -> bool:
    """Return whether a name only counts: `joint1`, `joint_2`."""
    return _letters(name) <= _NUMBERED


def _letters(name: str) -> set[str]:
    return {word for word in re.split(r"[^a-z]+", name.lower()) if word}
