"""The pose goals that a controller sought, and by how much to move those that were not reached."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from tracerisk.ros.drafts.shifted_poses import PlaceAndShift, Vector, reachable_shift
from tracerisk.ros.moveit.plan_records import PoseGoal
from tracerisk.ros.transforms.poses import compose, inverse
from tracerisk.twin.physics.motion import PlanningError, Pose

_MOST_SOUGHT = 200  # goals that are kept
_SAME_PLACE = 0.02  # seen from above: what was made of one pose [m]

Reach = Callable[[str, Sequence[PoseGoal]], object]
"""Raises PlanningError where a group cannot reach the goals, one a link."""


class SoughtGoals:
    """The pose goals of one run, each with whether it was reached when last planned to."""

    def __init__(self) -> None:
        self._sought: dict[tuple[str, PoseGoal], bool] = {}

    def note(self, group: str, goals: Sequence[Sequence[PoseGoal]], *, is_reached: bool) -> None:
        """Keep whether the first of the alternatives was reached."""
        for goal in next(iter(goals), ()):
            if len(self._sought) < _MOST_SOUGHT or (group, goal) in self._sought:
                self._sought[group, goal] = is_reached

    def shift_to_reach(self, base: Pose, reach: Reach) -> PlaceAndShift | None:
        """Return the first place that was not reached, and by how much to move it, in the base.

        What was reached above or below it is to be reached as well. None where all was reached, or
        nothing that is tried helps.
        """
        seen = {key: compose(inverse(base), key[1].pose) for key in self._sought}
        missed = [seen[key] for key, is_reached in self._sought.items() if not is_reached]
        if not missed:
            return None
        x, y, z = missed[0].position
        wanted = [
            (group, goal, pose)
            for (group, goal), pose in seen.items()
            if abs(pose.position[0] - x) < _SAME_PLACE and abs(pose.position[1] - y) < _SAME_PLACE
        ]

        def is_reached(shift: Vector) -> bool:
            for group, goal, pose in wanted:
                a, b, c = (value + by for value, by in zip(pose.position, shift, strict=True))
                there = compose(base, Pose((a, b, c), pose.orientation))
                try:
                    reach(group, [replace(goal, pose=there)])
                except PlanningError:
                    return False
            return True

        row = reachable_shift((x, y, z), is_reached)
        return None if row is None else ((x, y, z), row)
