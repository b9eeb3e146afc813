"""Servers of actions."""

from rclpy._action_server import (
    ActionServer,
    CancelResponse,
    GoalResponse,
    RCLError,
    ServerGoalHandle,
    default_cancel_callback,
    default_goal_callback,
    default_handle_accepted_callback,
)

__all__ = [
    "ActionServer",
    "CancelResponse",
    "GoalResponse",
    "RCLError",
    "ServerGoalHandle",
    "default_cancel_callback",
    "default_goal_callback",
    "default_handle_accepted_callback",
]
