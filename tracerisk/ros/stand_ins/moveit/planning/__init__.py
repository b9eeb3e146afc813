# ruff: noqa: F401 - what is imported here is what the module gives
"""Planning and execution: MoveItPy and what it hands out."""

from tracerisk.ros.imports.exported import exported as _exported

from ._moveit_py import MoveItPy
from ._parameters import MultiPipelinePlanRequestParameters, PlanRequestParameters
from ._planning_component import PlanningComponent
from ._scene_monitor import (
    LockedPlanningSceneContextManagerRO,
    LockedPlanningSceneContextManagerRW,
    PlanningSceneMonitor,
)
from ._trajectory_execution_manager import TrajectoryExecutionManager

__all__ = _exported(globals())
