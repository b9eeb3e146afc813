"""Where the links of the twin were, as `tf2_msgs/msg/TFMessage`.

A transform holds one joint: its frame on the parent link, then its turn or shift by the position
that was sampled. The base of the robot is the world, as for a controller on the twin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import rotation
from tracerisk.common.geometry.rotation import quaternion_of
from tracerisk.pipeline.recordings.recorded_topics import WORLD
from tracerisk.pipeline.recordings.writing.cdr import Cdr
from tracerisk.pipeline.recordings.writing.packed import Rows, Times, put, put_stamps
from tracerisk.twin.recording.samples import Samples
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Attachment

_PLACE_BYTES = 24
_AT_REST = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
_Numbers = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Frame:
    """A link on its parent."""

    parent: str
    """The name of the parent frame."""
    child: str
    """The name of the link."""
    pose: Sequence[float]
    """The place [m], then the quaternion (x, y, z, w); (7,)."""


def fixed_frames(robot: Robot, samples: Samples) -> bytes:
    """Return the one message of what never moves: the base in the world, and fixed links."""
    moving = {attachment.name for attachment in _moving(robot, samples)}
    frames = [
        _fixed(attachment) for attachment in robot.attachments if attachment.name not in moving
    ]
    if WORLD not in robot.link_names:
        frames.insert(0, _Frame(WORLD, robot.base_link, _AT_REST))
    data, _, _ = _message(frames)
    return data


class MovingFrames:
    """The messages of the links that joints move: all are copies of `template`, but for numbers."""

    def __init__(self, robot: Robot, samples: Samples) -> None:
        moving = _moving(robot, samples)
        self.template, self._stamps, poses = _message([_fixed(attachment) for attachment in moving])
        joints = samples.header.joints
        self._turns: list[tuple[int, int, _Numbers, _Numbers]] = []
        self._shifts: list[tuple[int, int, _Numbers, _Numbers]] = []
        for attachment, pose in zip(moving, poses, strict=True):
            column = joints.index(attachment.name)
            axis = np.array(attachment.axis) / np.linalg.norm(attachment.axis)
            if attachment.type == "prismatic":
                along = rotation(attachment.rpy) @ axis
                self._shifts.append((pose, column, np.array(attachment.xyz), along))
                continue
            w, *xyz = quaternion_of(attachment.rpy)
            # The product of the frame's quaternion with that of half a turn about the axis.
            turned = np.array((*(w * axis + np.cross(xyz, axis)), -np.dot(xyz, axis)))
            self._turns.append((pose + _PLACE_BYTES, column, np.array((*xyz, w)), turned))

    def fill(self, out: Rows, times: Times, positions: _Numbers) -> None:
        """Put the frames into `out` (n, len(template)); positions: (n, n_joints) [rad or m]."""
        put_stamps(out, self._stamps, times)
        cosine, sine = np.cos(positions / 2), np.sin(positions / 2)
        for at, column, still, turned in self._turns:
            put(out, at, cosine[:, column, None] * still + sine[:, column, None] * turned)
        for at, column, still, along in self._shifts:
            put(out, at, still + positions[:, column, None] * along)


def _moving(robot: Robot, samples: Samples) -> list[Attachment]:
    joints = set(samples.header.joints)
    return [
        attachment
        for attachment in robot.attachments
        if attachment.type != "fixed" and attachment.name in joints
    ]


def _fixed(each: Attachment) -> _Frame:
    w, x, y, z = quaternion_of(each.rpy)
    return _Frame(each.parent, each.child, (*each.xyz, x, y, z, w))


def _message(frames: Sequence[_Frame]) -> tuple[bytes, list[int], list[int]]:
    """Return a message of the time 0, and where its stamps and its poses stand."""
    out = Cdr()
    out.number("I", len(frames))
    stamps, poses = [], []
    for frame in frames:
        stamps.append(out.stamp(0))
        out.text(frame.parent)
        out.text(frame.child)
        poses.append(out.doubles(frame.pose, counted=False))
    return bytes(out.data), stamps, poses
