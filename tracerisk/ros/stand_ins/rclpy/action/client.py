"""Clients of actions."""

from rclpy._action_client import ActionClient, ClientGoalHandle

__all__ = ["ActionClient", "ClientGoalHandle"]
