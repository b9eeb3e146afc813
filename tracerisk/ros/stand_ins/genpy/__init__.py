# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for genpy: the base of messages, and the primitives `time` and `duration`."""

from tracerisk.ros.imports.exported import exported as _exported

from .message import DeserializationError, Message, MessageException, SerializationError, struct_I
from .rostime import Duration, Time, TVal

__all__ = _exported(globals())
