"""The pose goals that a controller sought, and by how much to move those that were not reached."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from tracerisk.ros.drafts.shifted_poses import PlaceAndShift, Vector, reachable_shift
from tracerisk.ros.moveit.plan_records import PoseGoal
from tracerisk.ros.transforms.poses import compose, inverse
from tracerisk.twin.physics.motion import PlanningError, Pose

_MOST_SOUGHT = 200  # goals that are kept
_MOST_LIFTED = 8  # goals for which a mount is sought
_HEIGHTS = tuple(round(0.1 * number, 1) for number in range(-3, 16) if number)  # of tables [m]
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

    def mount_to_reach(self, base: Pose, reach: Reach) -> float | None:
        """Return how high the base must stand [m] that the first goals are reached, as none was.

        Of the heights that help it is the middle one: what comes later is likely about there.
        None where a goal was reached, or no height helps.
        """
        if not self._sought or any(self._sought.values()):
            return None
        goals = list(self._sought)[:_MOST_LIFTED]
        helpful = [
            height
            for height in _HEIGHTS
            if all(_is_reached(reach, base, *goal, (0.0, 0.0, -height)) for goal in goals)
        ]
        return helpful[len(helpful) // 2] if helpful else None

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
            key
            for key, pose in seen.items()
            if abs(pose.position[0] - x) < _SAME_PLACE and abs(pose.position[1] - y) < _SAME_PLACE
        ]

        def is_reached(shift: Vector) -> bool:
            return all(_is_reached(reach, base, *goal, shift) for goal in wanted)

        row = reachable_shift((x, y, z), is_reached)
        return None if row is None else ((x, y, z), row)


def _is_reached(reach: Reach, base: Pose, group: str, goal: PoseGoal, shift: Vector) -> bool:
    """Return whether a group reaches a goal that is moved, by so much in the frame of the base."""
    pose = compose(inverse(base), goal.pose)
    x, y, z = (value + by for value, by in zip(pose.position, shift, strict=True))
    try:
        reach(group, [replace(goal, pose=compose(base, Pose((x, y, z), pose.orientation)))])
    except PlanningError:
        return False
    return True
