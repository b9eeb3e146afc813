# ruff: noqa: F401 - what is imported here is what the module gives
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

from tracerisk.ros.imports.exported import exported as _exported

__all__ = _exported(globals())
