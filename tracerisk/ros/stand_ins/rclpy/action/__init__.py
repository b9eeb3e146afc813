# ruff: noqa: F401 - what is imported here is what the module gives
"""Clients and servers of actions."""

from tracerisk.ros.imports.exported import exported as _exported

from .client import ActionClient
from .graph import (
    get_action_client_names_and_types_by_node,
    get_action_names_and_types,
    get_action_server_names_and_types_by_node,
)
from .server import ActionServer, CancelResponse, GoalResponse

__all__ = _exported(globals())
