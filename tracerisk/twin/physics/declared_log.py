"""The log of bodies that a controller declared while it ran, in files that outlive the run.

`declared.jsonl` has a line for each change of them, with all that are there from then on;
`declared_poses.bin` where those that can move were, beside the poses of the samples.
Both are appended to, so that what was logged stays readable however the process ended.
"""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.text.bounded import MOST_OF_A_RUN, file_bytes, file_text
from tracerisk.common.text.read_back import read_back
from tracerisk.errors import Location, LogError

_BODIES = "declared.jsonl"
_POSES = "declared_poses.bin"
DECLARED_FILES = (_BODIES, _POSES)
POSE = 7  # position and quaternion (w, x, y, z) in the world

Array = NDArray[np.float64]
Points = tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, slots=True)
class LoggedShape:
    """A declared body as the log has it."""

    name: str
    """The name under which the body was declared."""
    is_free: bool
    """Whether the body can move, so that its poses are logged."""
    pose: tuple[float, ...]
    """The world pose when it was declared: position [m], quaternion (w, x, y, z); (7,)."""
    shapes: tuple[Shape, ...] = ()
    """The primitives of the body."""
    hulls: tuple[Points, ...] = ()
    """The points of each convex hull in the body's frame [m], (n_hulls, n_points, 3)."""
    planes: tuple[tuple[float, ...], ...] = ()
    """Ground planes as poses in the body's frame, z pointing out of the ground, (n_planes, 7)."""


@dataclass(frozen=True, slots=True, eq=False)
class DeclaredChange:
    """All declared bodies that are simulated from one step on."""

    step: int
    """The first step with these bodies."""
    bodies: tuple[LoggedShape, ...]
    """The bodies; the free ones are in the order of their poses."""
    pose_steps: Array
    """The steps at which poses were logged, (n_poses,)."""
    poses: Array
    """Position [m] and quaternion (w, x, y, z) of the free bodies, (n_poses, n_free, 7)."""


class DeclaredLogWriter:
    """Appends to the log of declared bodies; raises OSError when the disk refuses."""

    def __init__(self, directory: Path) -> None:
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        self._bodies = os.open(directory / _BODIES, flags, 0o644)
        self._poses = os.open(directory / _POSES, flags, 0o644)

    def change(self, step: int, bodies: Sequence[LoggedShape]) -> None:
        """Note all that are there from `step` on."""
        line = {"step": step, "bodies": [dataclasses.asdict(body) for body in bodies]}
        os.write(self._bodies, (json.dumps(line, sort_keys=True) + "\n").encode())

    def pose(self, step: int, poses: Array) -> None:
        """Append where the free ones are at a step; poses: (7 n_free,)."""
        os.write(self._poses, np.concatenate(([step], poses)).tobytes())

    def close(self) -> None:
        """Close the files."""
        os.close(self._bodies)
        os.close(self._poses)


def read_declared(directory: Path) -> tuple[DeclaredChange, ...]:
    """Return the changes of declared bodies in a directory, as far as they were written.

    Returns none where nothing was declared. Raises LogError when the files do not fit each other.
    """
    path = directory / _BODIES
    if not path.exists():
        return ()
    try:
        lines = file_text(path, most=MOST_OF_A_RUN).split("\n")
        # The last line may have been cut short.
        read = [json.loads(line) for line in lines[:-1]]
        changes = [
            (int(line["step"]), tuple(read_back(LoggedShape, body) for body in line["bodies"]))
            for line in read
        ]
    except (AttributeError, KeyError, TypeError, ValueError) as cause:
        raise LogError(f"is no log of declared bodies: {cause}", Location(str(path))) from cause
    data = file_bytes(directory / _POSES, MOST_OF_A_RUN)
    flat = np.frombuffer(data[: len(data) // 8 * 8], dtype=np.float64)
    declared_changes, at = [], 0
    for index, (step, bodies) in enumerate(changes):
        n_free = sum(1 for body in bodies if body.is_free)
        width = 1 + POSE * n_free
        last = changes[index + 1][0] if index + 1 < len(changes) else np.inf
        begin = at
        while n_free and at + width <= len(flat) and step <= flat[at] < last:
            at += width
        rows = flat[begin:at].reshape(-1, width)
        poses = rows[:, 1:].reshape(len(rows), n_free, POSE)
        declared_changes.append(DeclaredChange(step, bodies, rows[:, 0], poses))
    return tuple(declared_changes)
