"""A gripper as a planning group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ._gripper import Gripper
from ._messages import init_dummy_joint_trajectory_from_state, init_joint_state
from .moveit2 import MoveIt2

__all__ = ["MoveIt2Gripper"]


class MoveIt2Gripper(Gripper, MoveIt2):
    """Opens and closes a gripper by plans, or by trajectories of one point."""

    def __init__(
        self,
        node: Any,
        gripper_joint_names: Sequence[str],
        open_gripper_joint_positions: Sequence[float],
        closed_gripper_joint_positions: Sequence[float],
        gripper_group_name: str = "gripper",
        execute_via_moveit: bool = False,
        ignore_new_calls_while_executing: bool = False,
        skip_planning: bool = False,
        skip_planning_fixed_motion_duration: float = 0.5,
        callback_group: Any = None,
        follow_joint_trajectory_action_name: str = "DEPRECATED",
        use_move_group_action: bool = False,
    ) -> None:
        super().__init__(
            node,
            gripper_joint_names,
            "",
            "",
            gripper_group_name,
            execute_via_moveit,
            ignore_new_calls_while_executing,
            callback_group,
            follow_joint_trajectory_action_name,
            use_move_group_action,
        )
        self._opened = [float(each) for each in open_gripper_joint_positions]
        self._closed = [float(each) for each in closed_gripper_joint_positions]
        self._skips_planning = skip_planning
        self._skip_s = skip_planning_fixed_motion_duration
        self._ends = list(zip(self._opened, self._closed, strict=True))

    def move_to_position(self, position: float) -> None:
        """Move every finger to a position."""
        self.move_to_configuration([position] * len(self.joint_names))

    def reset_open(self, sync: bool = True) -> None:
        """Send the fingers to where they are open."""
        self.reset_controller(self._opened)

    def reset_closed(self, sync: bool = True) -> None:
        """Send the fingers to where they are closed."""
        self.reset_controller(self._closed)

    def _go(self, positions: Sequence[float]) -> None:
        if not self._skips_planning:
            self.move_to_configuration(positions)
            return
        seconds = int(self._skip_s)
        state = init_joint_state(self.joint_names, positions)
        rest = int((self._skip_s - seconds) * 1e9)
        self.execute(init_dummy_joint_trajectory_from_state(state, seconds, rest))
