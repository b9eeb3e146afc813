"""Redo the risk assessment of a robot arm at every commit of its ROS controller."""

from tracerisk.api import (
    annotate,
    assess,
    build,
    check,
    diff,
    load_controller,
    load_hardware,
    load_settings,
    overrides,
    refresh,
    solve,
    strip,
    trace_controller,
    write_blocks,
)
from tracerisk.common.version import __version__ as __version__

__all__ = [
    "annotate",
    "assess",
    "build",
    "check",
    "diff",
    "load_controller",
    "load_hardware",
    "load_settings",
    "overrides",
    "refresh",
    "solve",
    "strip",
    "trace_controller",
    "write_blocks",
]
