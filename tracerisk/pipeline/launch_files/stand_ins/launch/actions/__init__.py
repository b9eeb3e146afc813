# ruff: noqa: F401 - what is imported here is what the module gives
"""`launch.actions`."""

from tracerisk.pipeline.launch_files.stand_ins.launch.actions.flow import (
    EmitEvent,
    ForEach,
    ForLoop,
    GroupAction,
    IncludeLaunchDescription,
    LogInfo,
    OpaqueCoroutine,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
    ShutdownAction,
    TimerAction,
    UnregisterEventHandler,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.actions.processes import (
    ExecuteLocal,
    ExecuteProcess,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.actions.settings import (
    AppendEnvironmentVariable,
    DeclareLaunchArgument,
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    UnsetEnvironmentVariable,
    UnsetLaunchConfiguration,
)
from tracerisk.ros.imports.exported import exported as _exported

__all__ = _exported(globals())
