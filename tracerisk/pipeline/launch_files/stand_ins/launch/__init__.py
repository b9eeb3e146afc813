# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for `launch`: descriptions are walked through, and nothing is started."""

from tracerisk.pipeline.launch_files.stand_ins.launch import (
    actions,
    conditions,
    event_handlers,
    events,
    launch_description_sources,
    logging,
    substitutions,
    utilities,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.action import Action
from tracerisk.pipeline.launch_files.stand_ins.launch.condition import Condition
from tracerisk.pipeline.launch_files.stand_ins.launch.event_handlers import EventHandler
from tracerisk.pipeline.launch_files.stand_ins.launch.events import Event
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_context import LaunchContext
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description import (
    LaunchDescription,
    LaunchDescriptionEntity,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description_source import (
    LaunchDescriptionSource,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_service import (
    LaunchIntrospector,
    LaunchService,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.some_substitutions_type import (
    SomeSubstitutionsType,
    SomeSubstitutionsType_types_tuple,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.substitution import Substitution
from tracerisk.ros.imports.exported import exported as _exported

__all__ = _exported(
    globals(),
    *("actions", "conditions", "event_handlers", "events"),
    *("launch_description_sources", "logging", "substitutions", "utilities"),
)
