# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for rosbag2_py: messages recorded in bags of ROS 2 and read from them (db3, MCAP)."""

from tracerisk.ros.imports.exported import exported as _exported

from ._bag import SequentialReader, SequentialWriter
from ._description import (
    BagMetadata,
    ConverterOptions,
    FileInformation,
    Info,
    ReadOrder,
    ReadOrderSortBy,
    StorageFilter,
    StorageOptions,
    TopicInformation,
    TopicMetadata,
    get_registered_readers,
    get_registered_serializers,
    get_registered_writers,
)

__all__ = _exported(globals())
