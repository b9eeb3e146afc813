"""The stages joined: run a controller, annotate it, build its model, solve it."""

from tracerisk.pipeline.controller import Controller, load_controller
from tracerisk.pipeline.stages import (
    Annotated,
    annotate,
    at_annotated_lines,
    build,
    check_blocks,
    hand_set,
    load_hardware,
    load_robot,
    load_settings,
    solve,
    strip,
    trace_controller,
)

__all__ = [
    "Annotated",
    "Controller",
    "annotate",
    "at_annotated_lines",
    "build",
    "check_blocks",
    "hand_set",
    "load_controller",
    "load_hardware",
    "load_robot",
    "load_settings",
    "solve",
    "strip",
    "trace_controller",
]
