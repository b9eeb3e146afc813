"""A gripper by whichever interface its driver has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .gripper_command import GripperCommand
from .moveit2_gripper import MoveIt2Gripper

__all__ = ["GripperInterface"]


class GripperInterface:
    """Opens and closes a gripper by GripperCommand where that is served, else by plans."""

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
        max_effort: float = 0.0,
        callback_group: Any = None,
        follow_joint_trajectory_action_name: str = "DEPRECATED",
        gripper_command_action_name: str = "gripper_action_controller/gripper_cmd",
        use_move_group_action: bool = False,
    ) -> None:
        command = GripperCommand(
            node,
            gripper_joint_names,
            open_gripper_joint_positions,
            closed_gripper_joint_positions,
            max_effort,
            ignore_new_calls_while_executing,
            callback_group,
            gripper_command_action_name,
        )
        self._interface: Any = command
        if not command.gripper_command_action_client.wait_for_server(timeout_sec=1.0):
            self._interface = MoveIt2Gripper(
                node,
                gripper_joint_names,
                open_gripper_joint_positions,
                closed_gripper_joint_positions,
                gripper_group_name,
                execute_via_moveit,
                ignore_new_calls_while_executing,
                skip_planning,
                skip_planning_fixed_motion_duration,
                callback_group,
                follow_joint_trajectory_action_name,
                use_move_group_action,
            )

    def __call__(self) -> None:
        """Toggle the gripper."""
        self._interface.toggle()

    def __getattr__(self, name: str) -> Any:
        """Return what the interface that is used has."""
        if name == "_interface":
            raise AttributeError(name)
        return getattr(self._interface, name)
