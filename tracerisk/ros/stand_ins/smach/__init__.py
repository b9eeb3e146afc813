"""Stand-in for smach: hierarchical state machines; it gives way to one of the workspace's own."""

from .concurrence import Concurrence
from .container import Container
from .exceptions import (
    InvalidConstructionError,
    InvalidStateError,
    InvalidTransitionError,
    InvalidUserCodeError,
    PreemptError,
)
from .iterator import Iterator
from .log import is_shutdown as is_shutdown
from .log import logdebug, logerr, loginfo, logwarn, set_loggers, set_shutdown_check
from .sequence import Sequence
from .state import CBState, State, cb_interface, has_smach_interface
from .state_machine import StateMachine
from .user_data import Remapper, UserData

__all__ = [
    "CBState",
    "Concurrence",
    "Container",
    "InvalidConstructionError",
    "InvalidStateError",
    "InvalidTransitionError",
    "InvalidUserCodeError",
    "Iterator",
    "PreemptError",
    "Remapper",
    "Sequence",
    "State",
    "StateMachine",
    "UserData",
    "cb_interface",
    "has_smach_interface",
    "is_shutdown",
    "logdebug",
    "logerr",
    "loginfo",
    "logwarn",
    "set_loggers",
    "set_shutdown_check",
]
