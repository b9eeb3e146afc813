"""The motion that a described driver has planned, and carries out at a later request."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.ros.moveit.trajectory_execution import START_TOLERANCE
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError


@dataclass(slots=True, eq=False)
class PlannedMotion:
    """Keeps the latest plan; a request that cannot be planned leaves the one before."""

    _trajectory: JointTrajectory | None = None
    """The plan; `None` before the first one."""
    _begins: tuple[float, ...] = ()
    """(n_joints,) where the arm was when it was planned [rad or m]."""

    def keep(self, trajectory: JointTrajectory | None, positions: Sequence[float]) -> None:
        """Keep a plan of an arm that is at `positions`; what needs no motion is none."""
        self._trajectory, self._begins = trajectory, tuple(positions)

    def begun_at(self, joints: Sequence[str], positions: Sequence[float]) -> JointTrajectory:
        """Return the plan, which begins where the arm is.

        Raises:
            PlanningError: nothing is planned, or the plan begins elsewhere.
        """
        plan = self._trajectory
        if plan is None:
            raise PlanningError("bad_request", "nothing was planned before; plan a motion first")
        for joint, here, begins in zip(joints, positions, self._begins, strict=True):
            if abs(here - begins) > START_TOLERANCE:
                words = f"the plan begins at {begins:.3g} of {joint}, which is at {here:.3g}"
                raise PlanningError("bad_request", f"{words}; plan again")
        return plan
