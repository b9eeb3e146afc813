"""Stand-in for `launch_ros`: nodes are noted with all they are given, and none is started."""

from tracerisk.pipeline.launch_files.stand_ins.launch_ros import (
    actions,
    descriptions,
    event_handlers,
    events,
    parameter_descriptions,
    substitutions,
)

__all__ = [
    "actions",
    "descriptions",
    "event_handlers",
    "events",
    "parameter_descriptions",
    "substitutions",
]
