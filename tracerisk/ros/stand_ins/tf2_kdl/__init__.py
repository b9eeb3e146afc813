"""Stand-in for tf2_kdl: importing it lets buffers transform vectors and frames of PyKDL."""

from .tf2_kdl import (
    do_transform_frame,
    do_transform_twist,
    do_transform_vector,
    do_transform_wrench,
    from_msg_frame,
    from_msg_vector,
    to_msg_frame,
    to_msg_vector,
    transform_to_kdl,
)

__all__ = [
    "do_transform_frame",
    "do_transform_twist",
    "do_transform_vector",
    "do_transform_wrench",
    "from_msg_frame",
    "from_msg_vector",
    "to_msg_frame",
    "to_msg_vector",
    "transform_to_kdl",
]
