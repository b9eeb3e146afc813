# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for smach: hierarchical state machines; it gives way to one of the workspace's own."""

from tracerisk.ros.imports.exported import exported as _exported

from .concurrence import Concurrence
from .container import Container
from .exceptions import *  # noqa: F403 - each name of it
from .iterator import Iterator
from .log import is_shutdown as is_shutdown
from .log import logdebug, logerr, loginfo, logwarn, set_loggers, set_shutdown_check
from .sequence import Sequence
from .state import CBState, State, cb_interface, has_smach_interface
from .state_machine import StateMachine
from .user_data import Remapper, UserData

__all__ = _exported(globals())
