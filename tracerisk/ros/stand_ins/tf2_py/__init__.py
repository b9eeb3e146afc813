# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for tf2_py: the buffer of tf2 and its exceptions."""

from tracerisk.ros.imports.exported import exported as _exported

from .buffer_core import BufferCore
from .exceptions import *  # noqa: F403 - each name of it

__all__ = _exported(globals())
