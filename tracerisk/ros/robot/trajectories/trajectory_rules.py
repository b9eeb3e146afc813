"""What a robot's driver does with trajectories that ask for more than the robot can do."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tracerisk.twin.motion.plausible_units import past_limits

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.physics.motion import JointTrajectory
    from tracerisk.twin.robots.robot import Robot

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
    trajectory: JointTrajectory, robot: Robot
) -> tuple[JointTrajectory, dict[str, str]]:
    """Return a trajectory that stops at the joints' limits, and for each joint how it was past."""
    position, velocity = trajectory.position.copy(), trajectory.velocity.copy()
    past: dict[str, str] = {}
    for i, name in enumerate(trajectory.joints):
        joint = robot.joint(name)
        if joint.type == "continuous":
            continue
        asked = position[:, i]
        reached = np.clip(asked, joint.lower, joint.upper)
        furthest = asked[int(np.argmax(np.abs(asked - reached)))]
        if np.abs(asked - reached).max() > _NEAR:
            past[name] = f"to {past_limits(joint, furthest, _NEAR)}; it stops there"
        velocity[:, i] = np.where(reached == asked, velocity[:, i], 0.0)
        position[:, i] = reached
    return replace(trajectory, position=position, velocity=velocity), past
