"""A gripper by the action GripperCommand."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import Any

from action_msgs.msg import GoalStatus
from control_msgs.action import GripperCommand as GripperCommandAction
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState

from ._gripper import Gripper
from ._waiting import OnNode, wait_until
from .utils import enum_to_str

__all__ = ["GripperCommand"]


class GripperCommand(Gripper, OnNode):
    """Opens and closes a gripper by goals."""

    _moves_each = False

    def __init__(
        self,
        node: Any,
        gripper_joint_names: Sequence[str],
        open_gripper_joint_positions: Any,
        closed_gripper_joint_positions: Any,
        max_effort: float = 0.0,
        ignore_new_calls_while_executing: bool = True,
        callback_group: Any = None,
        gripper_command_action_name: str = "gripper_action_controller/gripper_command",
    ) -> None:
        self._node = node
        self._names = list(gripper_joint_names)
        self._opened, self._closed = (
            [float(each)] if isinstance(each, float | int) else [float(one) for one in each]
            for each in (open_gripper_joint_positions, closed_gripper_joint_positions)
        )
        self._ends = list(zip(self._opened, self._closed, strict=False))
        self._effort = float(max_effort)
        self._ignores_calls = ignore_new_calls_while_executing
        self._is_requested = self._is_executing = False
        self._state: Any = None
        self._has_new_state = False
        self.gripper_command_action_client = ActionClient(
            node, GripperCommandAction, gripper_command_action_name, callback_group=callback_group
        )
        node.create_subscription(
            JointState, "joint_states", self._take_state, 1, callback_group=callback_group
        )

    def _go(self, positions: Sequence[float]) -> None:
        self.move_to_position(positions[0])

    def move_to_position(self, position: float) -> None:
        """Move the gripper to a position."""
        if self._ignores_calls and self._is_executing:
            return
        self._is_requested = True
        goal = GripperCommandAction.Goal()
        goal.command.position, goal.command.max_effort = float(position), self._effort
        client = self.gripper_command_action_client
        if not client.wait_for_server(timeout_sec=1.0):
            self._warn("Action server of the gripper is not yet ready.")
            return
        client.send_goal_async(goal).add_done_callback(self._answered)

    def reset_open(self, **kwargs: Any) -> None:
        """Open the gripper whatever goes on."""
        self.force_reset_executing_state()
        self.move_to_position(self._opened[0])

    def reset_closed(self, **kwargs: Any) -> None:
        """Close the gripper whatever goes on."""
        self.force_reset_executing_state()
        self.move_to_position(self._closed[0])

    def force_reset_executing_state(self) -> None:
        """Forget that a motion is requested or executed."""
        self._is_requested = self._is_executing = False

    def wait_until_executed(self) -> bool:
        """Wait for the end of a motion; False where none goes on."""
        if not self._is_requested and not self._is_executing:
            self._warn("Cannot wait until motion is executed (no motion is in progress).")
            return False
        wait_until(
            self._node,
            lambda: not self._is_requested and not self._is_executing,
            "the end of a motion of the gripper",
        )
        return True

    def _take_state(self, msg: Any) -> None:
        if all(name in msg.name for name in self._names):
            self._state, self._has_new_state = msg, True

    def _answered(self, future: Any) -> None:
        handle = future.result()
        self._is_requested = False
        if not handle.accepted:
            self._warn("The gripper's goal was rejected.")
            return
        self._is_executing = True
        handle.get_result_async().add_done_callback(self._ended)

    def _ended(self, future: Any) -> None:
        status = future.result().status
        if status != GoalStatus.STATUS_SUCCEEDED:
            text = enum_to_str(GoalStatus, status)
            self._node.get_logger().error(f"The gripper's goal was unsuccessful: {text}")
        self._is_executing = False

    joint_names = property(attrgetter("_names"), doc="The joints of the gripper.")

    @property
    def joint_state(self) -> Any:
        """The last joint states that hold all joints, None before."""
        return self._state

    @property
    def new_joint_state_available(self) -> bool:
        """Whether joint states came since `reset_new_joint_state_checker`."""
        return self._has_new_state

    def reset_new_joint_state_checker(self) -> None:
        """Forget that joint states came."""
        self._has_new_state = False
