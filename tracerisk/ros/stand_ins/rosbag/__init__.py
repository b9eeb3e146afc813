"""Stand-in for rosbag: messages recorded in files and read from them (format 2.0)."""

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

__all__ = [
    "Bag",
    "BagMessage",
    "Compression",
    "ROSBagEncryptException",
    "ROSBagEncryptNotSupportedException",
    "ROSBagException",
    "ROSBagFormatException",
    "ROSBagUnindexedException",
]
