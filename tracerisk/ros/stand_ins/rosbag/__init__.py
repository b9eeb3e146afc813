# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for rosbag: messages recorded in files and read from them (format 2.0)."""

from tracerisk.ros.imports.exported import exported as _exported

from .bag import (
    Bag,
    BagMessage,
    Compression,
    ROSBagEncryptException,
    ROSBagEncryptNotSupportedException,
    ROSBagException,
    ROSBagFormatException,
    ROSBagUnindexedException,
)

__all__ = _exported(globals())
