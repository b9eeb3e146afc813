"""The stages joined: run a controller, annotate it, build its model, solve it.

Each name is imported when it is first used, so that who needs one stage waits for no other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tracerisk.common.on_demand import on_demand

if TYPE_CHECKING:
    from tracerisk.pipeline.failure_data.explanation import explain as explain
    from tracerisk.pipeline.stages import Annotated as Annotated
    from tracerisk.pipeline.stages import annotate as annotate
    from tracerisk.pipeline.stages import at_annotated_lines as at_annotated_lines
    from tracerisk.pipeline.stages import build as build
    from tracerisk.pipeline.stages import check_blocks as check_blocks
    from tracerisk.pipeline.stages import hand_set as hand_set
    from tracerisk.pipeline.stages import load_hardware as load_hardware
    from tracerisk.pipeline.stages import load_robot as load_robot
    from tracerisk.pipeline.stages import load_settings as load_settings
    from tracerisk.pipeline.stages import solve as solve
    from tracerisk.pipeline.stages import strip as strip
    from tracerisk.pipeline.stages import trace_controller as trace_controller
    from tracerisk.pipeline.workspace.controller import Controller as Controller
    from tracerisk.pipeline.workspace.controller import load_controller as load_controller

_HOMES = {
    "failure_data.explanation": "explain",
    "stages": (
        "Annotated annotate at_annotated_lines build check_blocks hand_set load_hardware "
        "load_robot load_settings solve strip trace_controller"
    ),
    "workspace.controller": "Controller load_controller",
}

__getattr__ = on_demand(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted([*globals(), *" ".join(_HOMES.values()).split()])
