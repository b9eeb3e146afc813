# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for tf, the first transform library of ROS 1, which rests on tf2."""

from tf2_ros import ConnectivityException, ExtrapolationException, LookupException
from tf2_ros import TransformException as Exception  # noqa: A004 - the real library's name

from tracerisk.ros.imports.exported import exported as _exported

from . import transformations
from .broadcaster import TransformBroadcaster
from .listener import Transformer, TransformerROS, TransformListener

__all__ = _exported(globals(), "transformations")
