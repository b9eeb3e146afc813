"""Names that a robot's driver has beside those of the joints, in trajectories and joint states.

A driver of a telescope takes one name for its whole length and shares the value among the joints
of its stages; that of a mobile arm takes names for its base, which stands still on the twin.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime


@dataclass(frozen=True, slots=True)
class JointName:
    """The meaning of a driver's own name."""

    moves: Mapping[str, float] = field(default_factory=dict)
    """The part of the value that each joint takes, by joint; empty where nothing moves."""
    note: str = ""
    """Why a name that moves nothing on the twin is accepted; else empty."""


class JointNames:
    """The names that the drivers of one run have; empty where none has any."""

    def __init__(self, runtime: Runtime | None = None) -> None:
        del runtime
        self._names: dict[str, JointName] = {}

    def add(self, names: Mapping[str, JointName]) -> None:
        """Take names of a driver; of a name that is known already the first meaning stays."""
        self._names = {**names, **self._names}

    def notes(self, names: Sequence[str]) -> dict[str, str]:
        """Return those of some names that move nothing on the twin, each with the reason."""
        notes = {name: self._names[name].note for name in names if name in self._names}
        return {name: note for name, note in notes.items() if note}

    def has_any(self, names: Sequence[str]) -> bool:
        """Return whether some names are a driver's, and not the robot's."""
        return any(name in self._names for name in names)

    def spread(self, names: Sequence[str], values: Sequence[float]) -> dict[str, float]:
        """Return the value of each joint that is meant; names of no driver stay as they are."""
        table: dict[str, float] = {}
        for name, value in zip(names, values, strict=True):
            meaning = self._names.get(name)
            parts = {name: 1.0} if meaning is None else meaning.moves
            table.update((joint, part * value) for joint, part in parts.items())
        return table

    def value(self, name: str, joints: Mapping[str, float]) -> float:
        """Return the value of a name, from those of the joints: the nearest that they can have."""
        meaning = self._names.get(name)
        if meaning is None:
            return joints[name]
        scale = sum(part * part for part in meaning.moves.values())
        total = sum(part * joints[joint] for joint, part in meaning.moves.items())
        return total / scale if scale else 0.0

    def effort(self, name: str, joints: Mapping[str, float]) -> float:
        """Return the effort along a name, from those of the joints: they do the same work."""
        moves = self._names[name].moves
        return sum(part * joints[joint] for joint, part in moves.items())

    def joints_of(self, name: str) -> tuple[str, ...]:
        """Return the joints that a name of a driver moves."""
        return tuple(self._names[name].moves)

    @property
    def of_joints(self) -> tuple[str, ...]:
        """The names that move joints."""
        return tuple(name for name, meaning in self._names.items() if meaning.moves)

    def trajectory(self, message: Any) -> Any:
        """Return a trajectory_msgs/JointTrajectory by the names of the robot's own joints."""
        names = list(message.joint_names)
        if not self.has_any(names):
            return message
        made = copy.deepcopy(message)
        made.joint_names = [*self.spread(names, [0.0] * len(names))]
        for point in made.points:
            for rows in ("positions", "velocities", "accelerations"):
                values = list(getattr(point, rows))
                if len(values) == len(names):
                    setattr(point, rows, [*self.spread(names, values).values()])
            point.effort = []
        return made

    def goal(self, message: Any) -> Any:
        """Return a goal of FollowJointTrajectory by the names of the robot's own joints."""
        names = [*message.trajectory.joint_names]
        if not self.has_any(names):
            return message
        made = copy.copy(message)
        made.trajectory = self.trajectory(message.trajectory)
        for key in ("path_tolerance", "goal_tolerance"):
            setattr(made, key, [part for item in getattr(message, key) for part in self._of(item)])
        return made

    def _of(self, tolerance: Any) -> list[Any]:
        """Return the tolerances of the joints that a name moves, each its part of it."""
        meaning = self._names.get(tolerance.name)
        if meaning is None:
            return [tolerance]
        result = []
        for joint, part in meaning.moves.items():
            made = copy.deepcopy(tolerance)
            made.name = joint
            for key in ("position", "velocity", "acceleration"):
                # What is negative has no limit, whatever it is a part of.
                value = getattr(tolerance, key)
                setattr(made, key, value * abs(part) if value > 0.0 else value)
            result.append(made)
        return result
