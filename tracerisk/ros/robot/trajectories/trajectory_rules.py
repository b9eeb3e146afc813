"""What a robot's driver does with trajectories that ask for more than the robot can do."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.motion.plausible_units import past_limits

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.physics.motion import JointTrajectory
    from tracerisk.twin.robots.robot import Robot

Array = NDArray[np.float64]

_NEAR = 1e-6  # what is past a limit by less is rounding [rad or m]


class TrajectoryRules:
    """What the drivers of one run do; a driver that says nothing does neither.

    `stop_at_limits`: joints go to their limits where a trajectory leads past them, and its goal is
    reached there. `ignore_tolerances`: those of a goal's message, and its time, are not looked at.
    """

    def __init__(self, runtime: Runtime | None = None) -> None:
        del runtime
        self.stop_at_limits = False
        self.ignore_tolerances = False

    @property
    def has_own(self) -> bool:
        """Whether a driver says what it does: then it is no controller of joint trajectories."""
        return self.stop_at_limits or self.ignore_tolerances


def within_limits(
    trajectory: JointTrajectory, robot: Robot, slack: float = _NEAR
) -> tuple[JointTrajectory, dict[str, str]]:
    """Return a trajectory that stops at the joints' limits, and for each joint how it was past.

    `slack` is how far past a limit nothing is said [rad or m].
    """
    position, past = stopped_positions(trajectory.joints, trajectory.position, robot, slack)
    velocity = np.where(position == trajectory.position, trajectory.velocity, 0.0)
    return replace(trajectory, position=position, velocity=velocity), past


def stopped_positions(
    joints: Sequence[str], asked: Array, robot: Robot, slack: float = _NEAR
) -> tuple[Array, dict[str, str]]:
    """Return positions that stop at the joints' limits, and for each joint how it was past.

    `asked` and what is returned: a row for each point, a column for each joint [rad or m].
    `slack` is as for `within_limits`.
    """
    position = asked.copy()
    past: dict[str, str] = {}
    for i, name in enumerate(joints):
        joint = robot.joint(name)
        if joint.type == "continuous":
            continue
        position[:, i] = np.clip(asked[:, i], joint.lower, joint.upper)
        beyond = np.abs(asked[:, i] - position[:, i])
        furthest = int(np.argmax(beyond))
        if beyond[furthest] > slack:
            words = past_limits(joint, float(asked[furthest, i]), slack)
            past[name] = f"to {words}; it stops there"
    return position, past
