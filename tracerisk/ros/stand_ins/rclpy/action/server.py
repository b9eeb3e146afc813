"""Servers of actions."""

from .. import _action_server as _module
from .._action_server import *  # noqa: F403 - each name of it

__all__ = list(_module.__all__)
