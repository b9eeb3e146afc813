# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for tf2_ros, the buffer, listeners and broadcasters of tf2, of ROS 1 and of ROS 2."""

# The messages are names of the real package too: its modules are taken in whole.
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage
from tf2_py import *  # noqa: F403 - each name of it

from tracerisk.ros.imports.exported import exported as _exported

from .buffer_interface import (
    BufferInterface,
    ConvertRegistration,
    NotImplementedException,
    Stamped,
    TransformRegistration,
    TypeException,
    convert,
)

# Their modules need the interface of the package, as in the real one.
from .buffer import Buffer  # isort: skip
from .buffer_client import BufferClient  # isort: skip
from .static_transform_broadcaster import StaticTransformBroadcaster  # isort: skip
from .transform_broadcaster import TransformBroadcaster  # isort: skip
from .transform_listener import TransformListener  # isort: skip

__all__ = _exported(globals())
