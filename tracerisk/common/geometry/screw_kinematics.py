"""Kinematics by products of exponentials, as Interbotix's own library does them.

Source: K. Lynch, F. Park, "Modern Robotics", Cambridge 2017, sections 3.3, 4.1, 5.1 and 6.2.2.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import skew

Array = NDArray[np.float64]
_MOST_STEPS = 20
_SMALL = 1e-6


def forward(home: Array, screws: Array, positions: Sequence[float] | Array) -> Array:
    """Return the pose (4, 4) of the end effector.

    home: (4, 4), its pose with all joints at 0. screws: (6, n), the joints' axes there, rotation
    first, in the space frame. positions: (n,) [rad].
    """
    pose = np.array(home, dtype=np.float64)
    for index in reversed(range(len(positions))):
        pose = _exponential(screws[:, index] * float(positions[index])) @ pose
    return pose


def inverse(
    home: Array,
    screws: Array,
    goal: Array,
    guess: Sequence[float],
    orientation_tolerance: float,
    position_tolerance: float,
) -> tuple[Array, bool]:
    """Return joint positions for a pose, and whether they reach it: Newton and Raphson's steps.

    The search ends after 20 steps, as the book's does, wherever it then is.
    """
    positions = np.array(guess, dtype=np.float64)
    for step in range(_MOST_STEPS + 1):
        here = forward(home, screws, positions)
        twist = _adjoint(here) @ _logarithm(inverted(here) @ goal)
        missed = (
            float(np.linalg.norm(twist[:3])) > orientation_tolerance
            or float(np.linalg.norm(twist[3:])) > position_tolerance
        )
        if not missed or step == _MOST_STEPS:
            return positions, not missed
        positions = positions + np.linalg.pinv(_jacobian(screws, positions)) @ twist
    raise AssertionError("unreachable")


def inverted(pose: Array) -> Array:
    """Return the inverse of a pose (4, 4)."""
    turn = pose[:3, :3].T
    return np.block([[turn, (-turn @ pose[:3, 3])[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])


def _jacobian(screws: Array, positions: Array) -> Array:
    columns = np.array(screws, dtype=np.float64)
    moved = np.eye(4)
    for index in range(1, len(positions)):
        moved = moved @ _exponential(screws[:, index - 1] * positions[index - 1])
        columns[:, index] = _adjoint(moved) @ screws[:, index]
    return columns


def _adjoint(pose: Array) -> Array:
    turn, place = pose[:3, :3], pose[:3, 3]
    return np.block([[turn, np.zeros((3, 3))], [skew(place) @ turn, turn]])


def _exponential(twist: Array) -> Array:
    pose = np.eye(4)
    angle = float(np.linalg.norm(twist[:3]))
    if angle < _SMALL:
        pose[:3, 3] = twist[3:]
        return pose
    axis = skew(twist[:3] / angle)
    square = axis @ axis
    pose[:3, :3] = np.eye(3) + np.sin(angle) * axis + (1 - np.cos(angle)) * square
    lever = np.eye(3) * angle + (1 - np.cos(angle)) * axis + (angle - np.sin(angle)) * square
    pose[:3, 3] = lever @ twist[3:] / angle
    return pose


def _logarithm(pose: Array) -> Array:
    turn, place = pose[:3, :3], pose[:3, 3]
    cosine = min(max((float(np.trace(turn)) - 1) / 2, -1.0), 1.0)
    angle = float(np.arccos(cosine))
    if angle < _SMALL:
        return np.concatenate((np.zeros(3), place))
    if np.pi - angle < _SMALL:
        # A half turn: its axis is the column of R + 1 that is longest.
        doubled = turn + np.eye(3)
        longest = int(np.argmax(np.linalg.norm(doubled, axis=0)))
        axis = skew(doubled[:, longest] / np.linalg.norm(doubled[:, longest]))
    else:
        axis = (turn - turn.T) / (2 * np.sin(angle))
    square = axis @ axis
    lever = np.eye(3) / angle - axis / 2 + (1 / angle - 1 / np.tan(angle / 2) / 2) * square
    vector = np.array([axis[2, 1], axis[0, 2], axis[1, 0]])
    return np.concatenate((vector * angle, lever @ place * angle))
